"use strict";
// Plays calls of WebGL2 that the lab has collected. A call is [name, where, arguments]: a method of
// the context or of `own` below; `where` is 0 where nobody needs the result, a number under which
// the object is kept, or −1 where the result is part of the reply.
const makePlayer = () => {
  const gl = new OffscreenCanvas(1, 1).getContext("webgl2", { antialias: false, depth: false });
  if (gl === null) return null;
  gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
  gl.pixelStorei(gl.PACK_ALIGNMENT, 1);
  const objects = new Map();
  const extensions = {};
  for (const name of gl.getSupportedExtensions()) extensions[name] = gl.getExtension(name);

  // Names of constants, the extensions' among them, and what the device says of itself.
  const about = () => {
    const constants = {};
    for (const group of [gl, ...Object.values(extensions)])
      for (const name in group) if (typeof group[name] === "number") constants[name] ??= group[name];
    const info = extensions.WEBGL_debug_renderer_info;
    return {
      constants,
      extensions: Object.keys(extensions),
      renderer: gl.getParameter(info ? info.UNMASKED_RENDERER_WEBGL : gl.RENDERER),
      vendor: gl.getParameter(info ? info.UNMASKED_VENDOR_WEBGL : gl.VENDOR),
      version: gl.getParameter(gl.VERSION),
      glsl: gl.getParameter(gl.SHADING_LANGUAGE_VERSION),
      texture: gl.getParameter(gl.MAX_TEXTURE_SIZE),
      subpixel: gl.getParameter(gl.SUBPIXEL_BITS),
    };
  };

  // Compiles and links a program; the reply is why it can't be done, by stage, or "".
  const link = (program, texts, varyings) => {
    for (const [stage, text] of Object.entries(texts)) {
      const shader = gl.createShader(gl[`${stage.toUpperCase()}_SHADER`]);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
      gl.deleteShader(shader); // when the program is
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS))
        return [stage, gl.getShaderInfoLog(shader)];
    }
    if (!texts.vertex || !texts.fragment) return null; // the author's stage alone
    if (varyings.length) gl.transformFeedbackVaryings(program, varyings, gl.INTERLEAVED_ATTRIBS);
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) return ["", gl.getProgramInfoLog(program)];
    return null;
  };

  // A uniform's location, kept under a number; the reply is whether it has any effect.
  const locate = (program, to, names) => {
    const found = names.map((name) => gl.getUniformLocation(program, name)).find((at) => at);
    objects.set(to, found ?? null);
    return found !== undefined;
  };

  // Whether a fragment shader writes to an output, which has one of these names.
  const written = (program, names) =>
    names.some((name) => gl.getFragDataLocation(program, name) >= 0);

  const encoded = (values) => new Uint8Array(values.buffer).toBase64();

  // The first channels of the framebuffer's texels, which are read in fours.
  const pixels = (width, height, format, type, kind, channels) => {
    const all = new globalThis[kind](width * height * 4);
    gl.readPixels(0, 0, width, height, format, type, all);
    if (channels === 4) return all;
    const some = new globalThis[kind](width * height * channels);
    for (let at = 0, to = 0; at < all.length; at += 4)
      for (let channel = 0; channel < channels; ++channel) some[to++] = all[at + channel];
    return some;
  };
  const texels = (...how) => encoded(pixels(...how));

  const contents = (target, size) => {
    const bytes = new Uint8Array(size);
    gl.getBufferSubData(target, 0, bytes);
    return encoded(bytes);
  };

  const errors = () => {
    const found = [];
    for (let code = gl.getError(); code && found.length < 16; code = gl.getError()) found.push(code);
    return found;
  };

  const samples = (format) => [...gl.getInternalformatParameter(gl.RENDERBUFFER, format, gl.SAMPLES)];

  const release = (kind, number) => {
    gl[`delete${kind}`](objects.get(number));
    objects.delete(number);
  };

  // The offset of each member of a uniform block by its name.
  const offsets = (program, block) => {
    const numbers = gl.getActiveUniformBlockParameter(
      program, block, gl.UNIFORM_BLOCK_ACTIVE_UNIFORM_INDICES);
    const places = gl.getActiveUniforms(program, numbers, gl.UNIFORM_OFFSET);
    const names = [...numbers].map((number) => gl.getActiveUniform(program, number).name);
    return Object.fromEntries(names.map((name, at) => [name, places[at]]));
  };

  const own = {
    about, link, locate, written, pixels, texels, contents, errors, samples, offsets, release,
    pass() {},
  };

  // A constant by its name, "TEXTURE0+2" say.
  const constant = (words) => words.split("+")
    .reduce((sum, word) => sum + (gl[word] ?? Number(word)), 0);

  // What a recording's calls do once; all others are repeated for each frame. Levels are made anew
  // of what was copied into a texture.
  const ONCE = /^(create|link$|locate$|getUniform|tex(Storage|SubImage)|sampler|renderbuffer|vertexAttrib|enableVertex|uniformBlock)/;
  const repeated = (calls) => {
    let copied = false;
    return calls.filter(([name, , given]) => {
      copied = name === "copyTexSubImage2D" || (copied && name !== "texSubImage2D");
      if (name === "generateMipmap") return copied;
      return !ONCE.test(name) && (name !== "bufferData" || given[0] === "=UNIFORM_BUFFER");
    });
  };

  // The calls that draw all targets smaller, and what is copied from them, but no texture that is
  // given texels next.
  const SIZES = {
    viewport: [2, 4], scissor: [0, 4], blitFramebuffer: [0, 8], copyTexSubImage2D: [6, 8],
    texStorage2D: [3, 5], renderbufferStorageMultisample: [3, 5], pixels: [0, 2],
  };
  const shrink = (calls, scale) => calls.map((call, place) => {
    const [name, where, given] = call;
    const [from, to] = SIZES[name] ?? [0, 0];
    if (!to || /^(compressedT|t)exSubImage/.test(calls[place + 1]?.[0])) return call;
    const sizes = given.map((size, n) =>
      (n < from || n >= to || !size ? size : Math.max(1, Math.round(size * scale))));
    if (name === "texStorage2D") // with no more levels than that has
      sizes[1] = Math.min(sizes[1], 1 + Math.floor(Math.log2(Math.max(sizes[3], sizes[4]))));
    return [name, where, sizes];
  });

  const argument = (given, data) => {
    if (typeof given === "string" && given[0] === "=") return constant(given.slice(1));
    if (Array.isArray(given)) return given.map((each) => argument(each, data));
    if (given === null || typeof given !== "object") return given;
    if ("object" in given) return objects.get(given.object);
    if ("array" in given) return new globalThis[given.array](data, given.at, given.count);
    return given;
  };

  const bound = (data, [name, where, given]) =>
    [own[name] ?? gl[name], where, given.map((each) => argument(each, data))];
  const run = ([call, where, given]) => {
    const result = call.apply(gl, given);
    if (where > 0) objects.set(where, result);
    return result;
  };

  return {
    play(text) {
      const [calls, bytes] = JSON.parse(text);
      const data = Uint8Array.fromBase64(bytes).buffer;
      const reply = [];
      for (const call of calls) {
        const result = run(bound(data, call));
        if (call[1] < 0) reply.push(result ?? null);
      }
      return JSON.stringify({ reply, lost: gl.isContextLost() });
    },

    // Plays a recording, `scale` times as large: {lacks} says why it can't. `draw` draws it once
    // more, some `uniforms` being changed, and gives the pixels; `relink` gives why a program can't
    // be made of other texts.
    hold({ calls: recorded }, data, scale = 1) {
      if (!extensions.EXT_color_buffer_float) return { lacks: "this browser draws no floats" };
      if (!extensions.OES_texture_float_linear) // as on many phones: half floats are filtered
        for (const [name, , given] of recorded)
          if (name.startsWith("texStorage")) given[2] = given[2].replace(/^(=R\w*)32F$/, (_, word) => `${word}16F`);
      const names = new Map(recorded.filter(([name]) => name === "locate")
        .map(([, , [, number, words]]) => [number, words[0]]));
      const counted = [...names.values()].includes("shaderlab_height"); // rows, from above
      const calls = scale === 1 || counted ? recorded : shrink(recorded, scale);
      const refused = [];
      for (const call of calls) {
        const result = run(bound(data, call));
        if (call[0] === "link" && result) refused.push(result[1]);
      }
      if (refused.length) return { lacks: `this browser refuses a shader: ${refused[0]}` };

      // A uniform that has an effect and is no array, with its numbers where they stand.
      const uniformOf = ([name, , given]) => {
        const [, matrix, count, letter] = /^uniform(Matrix)?(\d)(f|i|ui)v$/.exec(name) ?? [];
        const called = letter && names.get(given[0].object);
        if (!called || called.startsWith("shaderlab_") || !objects.get(given[0].object)
          || given.at(-1).count !== (matrix ? count ** 2 : Number(count))) return [];
        return [{ name: called, matrix, whole: letter !== "f", now: argument(given.at(-1), data) }];
      };
      // Passes with the calls of each frame, and the names of those that they read.
      const arrange = () => repeated(calls).reduce((passes, call) => {
        const [name, reads, joined] = call[2];
        if (call[0] === "pass" && joined) passes.at(-1).names.push(name);
        else if (call[0] === "pass")
          passes.push({ names: [name], reads: [], calls: [], uniforms: [], draws: 1 });
        const pass = passes.at(-1);
        if (call[0] === "pass") pass.reads.push(...reads);
        pass.calls.push(bound(data, call));
        pass.uniforms.push(...uniformOf(call).map((made) => ({ ...made, pass, draw: pass.draws })));
        pass.draws += call[0].startsWith("draw") && call[0] !== "drawBuffers";
        return passes;
      }, []);
      let [passes, shown] = [arrange(), null];

      // A pass is drawn again if a number is another one, or a pass that it reads was drawn again.
      const draw = () => {
        const drawn = new Set();
        for (const pass of passes) {
          const numbers = pass.uniforms.map(({ now }) => now).join();
          if (numbers === pass.numbers && !pass.reads.some((name) => drawn.has(name))) continue;
          for (const call of pass.calls) {
            const result = run(call);
            if (call[1] < 0) shown = result;
          }
          pass.numbers = numbers;
          for (const name of pass.names) drawn.add(name);
        }
        return shown;
      };
      const relink = (number, texts) => {
        const made = gl.createProgram();
        const why = link(made, texts, []);
        if (why) return why;
        objects.set(number, made);
        for (const call of calls)
          if (/^(locate|getUniformBlockIndex|uniformBlockBinding)$/.test(call[0])
            && call[2][0].object === number) run(bound(data, call));
        passes = arrange();
        return null;
      };
      const lose = () => extensions.WEBGL_lose_context?.loseContext();
      const uniforms = passes.flatMap((pass) => pass.uniforms);
      return { draw, relink, size: calls.at(-1)[2].slice(0, 2), uniforms, errors, lose };
    },
  };
};
