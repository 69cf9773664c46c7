// A live picture: a recording of the calls that drew it, played with other uniforms. What the page's
// own script has for it comes as `tools`.

const make = (tag, given = {}, ...inside) => {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(given)) {
    if (name in made && name !== "list") made[name] = value;
    else made.setAttribute(name, value);
  }
  made.append(...inside);
  return made;
};
const label = (text, ...inside) => make("label", {}, make("span", { textContent: text }), ...inside);
const COLOUR = /colou?r|albedo|ambient|diffuse|specular|tint|emissi/i;

/** Numbers as colours: one channel in false colour over a range, several as they are. */
function paintLive(values, { size: [width, height], components }, [low, high], tools) {
  const packed = ([r, g, b]) => (r | g << 8 | b << 16 | 0xff000000) >>> 0;
  const [ramp, broken] = [Uint32Array.from(tools.ramp, packed), packed(tools.colours.broken)];
  const image = new ImageData(width, height);
  const out = new Uint32Array(image.data.buffer);
  const most = components === 1 ? ramp.length - 1 : 255;
  const scale = most / (high - low || 1);
  const level = (value) => Math.round(Math.max(0, Math.min(most, (value - low) * scale)));
  for (let i = 0, row = height - 1; row >= 0; row -= 1) {
    for (let column = 0; column < width; column += 1, i += 1) {
      const at = (row * width + column) * components;
      const r = values[at];
      const g = components > 1 ? values[at + 1] : low;
      const b = components > 2 ? values[at + 2] : low;
      if (!Number.isFinite(r + g + b)) out[i] = broken;
      else if (components === 1) out[i] = ramp[level(r)];
      else out[i] = level(r) | level(g) << 8 | level(b) << 16 | 0xff000000;
    }
  }
  return image;
}

/** The values that a picture's darkest and brightest colours stand for. */
function rangeOfPicture(values, { components, kind }) {
  if (components > 1 && kind !== "i" && kind !== "u") return [0, kind === "f" ? 1 : 255];
  return [Math.min, Math.max].map((of) => values.filter(Number.isFinite).reduce((a, b) => of(a, b)));
}

/** Where a camera stands, of which a matrix of turns and a shift is the view. */
const eyeOf = (view) => {
  const { m41, m42, m43 } = new DOMMatrix(view).inverse();
  return [m41, m42, m43];
};
const near = (a, b) => a.every((value, n) => Math.abs(value - b[n]) < 1e-3);
const isView = ({ name, matrix, own }) => matrix && own.length === 16 && /view/i.test(name)
  && !/light|shadow|proj/i.test(name) && [0, 1, 2, 4, 5, 6, 8, 9, 10].every((n) => Math.abs(own[n]
    - new DOMMatrix(own).inverse().toFloat64Array()[n % 4 * 4 + Math.floor(n / 4)]) < 1e-3);

/** A camera moved around the point in front of it that is nearest to the origin. */
function orbited(view, { around, up, away }) {
  const eye = eyeOf(view);
  const ahead = [-view[2], -view[6], -view[10]];
  const along = -eye.reduce((sum, e, n) => sum + e * ahead[n], 0);
  const distance = along > 0.1 ? along : Math.hypot(...eye) || 1;
  return [...new DOMMatrix().translate(0, 0, -distance * away).rotateAxisAngle(1, 0, 0, up)
    .multiply(new DOMMatrix([...view.slice(0, 12), 0, 0, 0, 1])).rotateAxisAngle(0, 1, 0, around)
    .translate(...eye.map((e, n) => -e - ahead[n] * distance)).toFloat64Array()];
}

/** A recording: what the lab says of it, and the numbers that its calls take, whose bytes come in
 * four planes. */
function unpack(bytes) {
  const length = Number(new DataView(bytes.buffer).getBigUint64(0, true));
  const about = JSON.parse(new TextDecoder().decode(bytes.subarray(8, 8 + length)));
  const planes = bytes.subarray(8 + length);
  const words = planes.length / 4;
  return { about, data: planes.map((_, n) => planes[n % 4 * words + (n >> 2)]).buffer };
}

/** Plays a recording; uniforms of one name and value are one. Throws where it can't be played. */
function play({ about, data }, scale = 1) {
  const held = makePlayer()?.hold(about, data, scale) ?? { lacks: "this browser has no WebGL2" };
  if (held.lacks) throw new Error(held.lacks);
  const found = new Map();
  for (const { now, pass, draw, ...uniform } of held.uniforms) {
    const key = `${uniform.name} ${now}`;
    if (!found.has(key)) found.set(key, { ...uniform, own: [...now], now, all: [], users: [] });
    found.get(key).all.push(now);
    found.get(key).users.push(pass.draws > 2 ? `${pass.names.at(-1)}, draw ${draw}` : pass.names.at(-1));
  }
  const started = performance.now();
  const [own, took, [error]] = [held.draw(), performance.now() - started, held.errors()];
  if (error) throw new Error(`this browser can't draw it (WebGL2 error ${error})`);
  return { ...held, about, show: { ...about.show, size: held.size }, own, took, uniforms: [...found.values()] };
}

/** Milliseconds that a frame may take; else it is drawn smaller while a control is moved. */
const FRAME = 25;

/** The largest difference of each pixel's channels to what the case's own values give, and the
 * largest of all that are finite. */
function differences(values, own, components) {
  const found = new Float32Array(values.length / components);
  let most = 0;
  for (let at = 0, n = 0; at < found.length; at += 1) {
    for (const end = n + components; n < end; n += 1)
      found[at] = Math.max(found[at], Math.abs(values[n] - own[n]));
    if (found[at] > most && found[at] < Infinity) most = found[at];
  }
  return [found, most];
}

class Panel {
  constructor(box, files, first, tools) {
    Object.assign(this, { tools, file: files[0], stops: 0 });
    this.canvas = make("canvas", { className: "live-canvas", tabIndex: 0, role: "img",
      "aria-label": "The live picture: arrow keys choose the pixel that is read" });
    this.judged = make("img", { alt: "the picture as it was judged" });
    this.caption = make("figcaption");
    this.reading = make("p", { className: "small live-reading" });
    this.controls = make("div", { className: "live-controls" });
    this.editor = make("details", { className: "fold" });
    this.mistakes = make("details", { className: "fold" });
    this.difference = make("input", { type: "checkbox", onchange: () => this.paint() });
    const choice = make("select", { onchange: async () => {
      this.file = files[choice.selectedIndex];
      this.start(await tools.open(this.file[1]));
    } }, ...files.map(([name]) => make("option", { textContent: name })));
    this.start(first); // nothing is shown where it can't be played
    box.append(
      make("div", { className: "live-pair" },
        make("figure", {}, this.judged, make("figcaption", { textContent: "Judged" })),
        make("figure", {}, this.canvas, this.caption)),
      this.reading,
      make("div", { className: "tool" }, ...(files.length > 1 ? [label("variant ", choice)] : []),
        make("button", { type: "button", textContent: "Back to what was judged", onclick: () => {
          this.difference.checked = false;
          this.start(this.bytes);
        } }),
        make("label", {}, this.difference, " difference to the judged picture")),
      this.controls, this.mistakes, this.editor,
    );
    this.offer(JSON.parse(box.dataset.mistakes ?? "[]"));
    this.watch();
    this.canvas.focus({ preventScroll: true });
  }

  start(bytes) {
    this.bytes = bytes;
    for (const each of [this.live, this.small]) each?.lose();
    const recording = unpack(bytes);
    this.live = play(recording);
    this.small = null;
    for (let scale = 1 / 2; scale > 1 / 16 && (this.small ?? this.live).took > FRAME; scale /= 2) {
      if (scale > 1 / 8 && this.live.took * scale * scale > FRAME) continue;
      this.small?.lose();
      this.small = play(recording, scale);
    }
    const [width, height] = this.live.show.size; // known before the file is there
    Object.assign(this.judged, { width, height, src: document.documentElement.dataset.root + this.file[2] });
    this.range = rangeOfPicture(this.live.own, this.live.show);
    this.camera = { around: 0, up: 0, away: 1 };
    this.views = this.live.uniforms.filter(isView);
    this.eyes = this.live.uniforms.filter(({ own, matrix }) => !matrix && own.length === 3
      && this.views.some((view) => near(eyeOf(view.own), own)));
    this.fill();
    for (const each of this.mistakes.querySelectorAll("button")) each.setAttribute("aria-pressed", false);
    this.shaders = editShaders(this.editor, this.live.about, (...given) => {
      const why = this.live.relink(...given);
      if (!why) this.small?.relink(...given);
      this.redraw();
      return why;
    });
    this.paint(this.live);
  }

  /** A button for each mistake that this picture's shaders can have, first those that no check detects,
   * which makes it and shows where that changes the picture, or leads back. */
  offer(mistakes) {
    const buttons = mistakes.filter((mistake) => this.shaders.change(mistake)).map((mistake) => {
      const { before, after, operator, noticed } = mistake;
      return make("button", { type: "button", "aria-pressed": false, onclick: ({ currentTarget: button }) => {
        this.difference.checked = button.getAttribute("aria-pressed") === "false";
        this.start(this.bytes);
        if (!this.difference.checked) return;
        const made = this.shaders.change(mistake);
        if (made) this.shaders.write(...made);
        button.setAttribute("aria-pressed", Boolean(made));
      } }, make("code", { textContent: before }), " became ", make("code", { textContent: after }),
      make("span", { className: "quiet", textContent: ` (${operator}), ${noticed ? `detected by ${noticed}` : "which no check detects"}` }));
    });
    if (buttons.length) this.mistakes.append(
      make("summary", { textContent: "Make a mistake: see where it shows" }), ...buttons);
    this.mistakes.hidden = !buttons.length;
  }

  /** Draws once more, as soon as the browser shows a frame; smaller first where that takes long. */
  redraw() {
    this.waiting ??= requestAnimationFrame(() => {
      this.waiting = null;
      this.paint(this.small ?? this.live);
      clearTimeout(this.resting);
      if (this.small) this.resting = setTimeout(() => this.paint(this.live), 300);
    });
  }

  paint(played = this.painted) {
    const { show, own } = played;
    Object.assign(this, { painted: played, values: played.draw() });
    let image, said = this.views.length ? "Live: drag it to move the camera" : "Live";
    const shade = make("span", { className: "live-shades", hidden: !this.difference.checked });
    if (this.difference.checked) {
      const [off, most] = differences(this.values, own, show.components);
      image = paintLive(off, { ...show, components: 1 }, [0, most], this.tools);
      said = `Difference: 0 (dark) to ${this.tools.general(most, 3)} (bright)`;
      shade.style.background = `linear-gradient(to right, ${this.tools.ramp.filter((_, n) => n % 15 === 0)
        .map((colour) => `rgb(${colour})`)})`;
    } else image = paintLive(this.values, show, this.range, this.tools);
    if (played === this.small) said += `, ${show.size.join(" × ")} pixels while it moves`;
    if (this.canvas.width !== image.width || this.canvas.height !== image.height)
      [this.canvas.width, this.canvas.height] = show.size;
    this.canvas.getContext("2d").putImageData(image, 0, 0);
    this.caption.replaceChildren(said, shade);
    this.read();
  }

  /** Says the numbers of the pixel that is read, or of another one from now on. */
  read(where = this.where ?? [0.5, 0.5]) {
    const { show: { size, components }, own } = this.painted;
    this.where = where.map((p) => Math.max(0, Math.min(1 - 1e-6, p)));
    const place = this.where.map((p, n) => Math.floor(p * size[n]));
    const at = (place[1] * size[0] + place[0]) * components;
    const words = (numbers) => Array.from(numbers.subarray(at, at + components),
      (value) => this.tools.general(value, 6)).join(", ");
    this.reading.textContent = `Pixel (${place.join(", ")}): live ${words(this.values)} · `
      + `with the case's own values ${words(own)}`;
  }

  watch() {
    const { canvas } = this;
    // A mouse or a finger reads a pixel; with a button down it moves the camera, if there is one.
    canvas.onpointerdown = canvas.onpointermove = ({ offsetX: x, offsetY: y, movementX, movementY, buttons }) => {
      const scale = 180 / canvas.clientWidth;
      const { around, up } = this.camera;
      if (buttons && this.views.length) this.turn({ around: around + movementX * scale, up: up + movementY * scale });
      this.read([x / canvas.clientWidth, 1 - y / canvas.clientHeight]);
    };
    canvas.onkeydown = (event) => {
      const step = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
      if (!step) return;
      event.preventDefault();
      const size = [canvas.width, canvas.height];
      this.read(this.where.map((p, n) => p + step[n] * (event.shiftKey ? 8 : 1) / size[n]));
    };
  }

  turn(change) {
    this.camera = { ...this.camera, ...change };
    for (const view of this.views) {
      const next = orbited(view.own, this.camera);
      for (const eye of this.eyes) if (near(eyeOf(view.own), eye.own)) this.put(eye, eyeOf(next));
      this.put(view, next);
    }
    for (const slider of this.turning) slider.value = this.camera[slider.name];
  }

  put(uniform, values) {
    for (const place of uniform.all) place.set(values);
    this.redraw();
  }

  /** A control for each uniform that can be moved. */
  fill() {
    const field = (title, ...inside) =>
      make("fieldset", {}, make("legend", { textContent: title }), ...inside);
    const limits = { around: [-180, 180], up: [-85, 85], away: [0.3, 3] };
    this.turning = Object.entries(limits).map(([name, [min, max]]) => make("input", { type: "range",
      name, min, max, step: 0.01, value: this.camera[name],
      oninput: ({ target }) => this.turn({ [name]: Number(target.value) }) }));
    this.canvas.classList.toggle("is-near", this.views.length > 0);
    // Those of one name stand together, the ones with a single value first, of others all but one folded.
    const named = Object.values(Object.groupBy(
      this.live.uniforms.filter((u) => !u.matrix && !this.eyes.includes(u)), ({ name }) => name));
    const fields = named.sort((one, other) => one.length - other.length).map((group) => {
      const [first, ...rest] = group.map((u) => [
        ...(group.length > 1 ? [make("p", { className: "quiet", textContent:
          `${u.users.slice(0, 2).join("; ")}${u.users.length > 2 ? ` and ${u.users.length - 2} more` : ""}` })] : []),
        ...this.inputs(u)]);
      return field(group[0].name, ...first, ...(rest.length ? [make("details", { className: "fold" },
        make("summary", { textContent: `its ${rest.length} other values` }), ...rest.flat())] : []));
    });
    if (this.views.length) {
      fields.unshift(field("camera (or drag the picture)",
        ...this.turning.map((slider) => label(slider.name, slider, make("span")))));
    }
    this.controls.replaceChildren(...fields);
    this.editor.open = !fields.length;
    if (!fields.length) this.controls.append("No number of this picture can be moved, but its shaders can be edited:");
  }

  /** Sliders of a uniform's numbers, which stop at the case's own, and a picker of a colour. */
  inputs(uniform) {
    const { own, name, whole, now } = uniform;
    const colour = COLOUR.test(name) && own.length >= 3 && own.every((v) => v >= 0 && v <= 1);
    const inputs = own.map((value, n) => {
      const far = whole ? Math.max(8, 2 * Math.abs(value)) : 2 * Math.abs(value) || 1;
      const max = !whole && value > 0 && (colour || value < 1) ? 1 : far;
      const min = value > 0 || now instanceof Uint32Array ? 0 : -far;
      const said = make("output", { textContent: this.tools.general(value, 4) });
      this.stops += 1; // a mark at the case's own value
      const stop = make("datalist", { id: `own-${this.stops}` }, make("option", { value }));
      const part = (colour ? "rgba" : "xyzw")[n];
      return label(own.length > 1 ? part : "", make("input", { type: "range", min, max, list: stop.id,
        step: whole ? 1 : (max - min) / 100, value, "aria-label": own.length > 1 ? `${name} ${part}` : name,
        oninput: ({ target }) => {
          const stops = Math.abs(target.value - value) < (max - min) / 150;
          const next = stops ? value : Number(target.value);
          const at = this.tools.general(next, 4);
          said.textContent = stops ? at : `${at}, was ${this.tools.general(value, 4)}`;
          this.put(uniform, Array.from(now, (old, m) => (m === n ? next : old)));
        } }), said, stop);
    });
    if (colour) {
      const hex = (v) => Math.round(v * 255).toString(16).padStart(2, "0");
      inputs.unshift(label("colour", make("input", { type: "color", value: `#${own.slice(0, 3).map(hex).join("")}`,
        "aria-label": name, oninput: ({ target }) => this.put(uniform, [...target.value
          .match(/\w\w/g).map((pair) => parseInt(pair, 16) / 255), ...now.slice(3)]) })));
    }
    return inputs;
  }
}

/** Fills a box with a recording's shaders, the longest first, compiled as they are typed. Returns how
 * one is written, and what a mistake would write, if it can be made: the shader and its text. */
function editShaders(box, { calls, files }, relink) {
  const stages = calls.filter(([call]) => call === "link")
    .flatMap(([, , [{ object: number }, texts]]) => Object.entries(files[number])
      .map(([stage, file]) => ({ number, texts, stage, file, all: Object.values(files[number]) })))
    .sort((one, other) => other.texts[other.stage].length - one.texts[one.stage].length);
  const select = make("select", { "aria-label": "shader" },
    ...stages.map(({ file }) => make("option", { textContent: file })));
  const lines = make("pre", { "aria-hidden": "true" });
  const text = make("textarea", { spellcheck: false, wrap: "off", "aria-label": "GLSL" });
  const errors = make("pre", { className: "live-errors", role: "status" });
  let [current, head, later] = [];
  const count = () => {
    const all = text.value.split("\n");
    lines.textContent = all.map((_, n) => n + 2).join("\n");
    text.rows = Math.min(30, all.length + 1);
  };
  const compile = () => {
    const texts = { ...current.texts, [current.stage]: head + text.value };
    const why = relink(current.number, texts);
    const above = head.split("\n").length - 2; // the author's text goes on with line 2
    errors.textContent = why?.[1].replaceAll("\0", "")
      .replace(/ERROR: \d+:(\d+)/g, (_, line) => `line ${line - above}`) ?? "";
    if (!why) Object.assign(current.texts, texts);
  };
  select.onchange = () => {
    current = stages[select.selectedIndex];
    const whole = current.texts[current.stage];
    const start = whole.indexOf("\n//\n") + 4;
    [head, text.value, errors.textContent] = [whole.slice(0, start), whole.slice(start), ""];
    count();
  };
  select.onchange();
  text.onscroll = () => { lines.scrollTop = text.scrollTop; };
  text.oninput = () => {
    count();
    clearTimeout(later);
    later = setTimeout(compile, 250);
  };
  box.replaceChildren(make("summary", { textContent: "Edit the shaders" }), select,
    make("div", { className: "live-editor" }, lines, text), errors);
  const change = ({ program, edit: [file, line, column, before, after] }) => {
    const stage = stages.find((each) => each.file === file && each.all.every((name) => program.includes(name)));
    const whole = stage?.texts[stage.stage] ?? "";
    const own = whole.slice(whole.indexOf("\n//\n") + 4); // from line 2
    const at = own.split("\n").slice(0, line - 2).reduce((sum, each) => sum + each.length + 1, column);
    return own.startsWith(before, at)
      && [stage, own.slice(0, at) + after + own.slice(at + before.length)];
  };
  const write = (stage, changed) => {
    select.selectedIndex = stages.indexOf(stage);
    select.onchange();
    text.value = changed;
    count();
    compile();
  };
  return { change, write };
}

globalThis.shaderlabLive = (...given) => new Panel(...given);
