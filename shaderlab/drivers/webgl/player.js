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
      points: gl.getParameter(gl.ALIASED_POINT_SIZE_RANGE)[1],
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

  const own = { about, link, locate, written, pixels, texels, contents, errors, samples, offsets, release };

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

    // Plays a recording: {lacks} says why it can't; `draw` draws it once more, some `uniforms` being
    // changed, and gives the pixels.
    hold({ calls }, data) {
      const filtered = calls.some(([name, , given]) => name === "texStorage2D" && /32F$/.test(given[2]))
        && calls.some(([name, , given]) => name === "samplerParameteri" && /LINEAR/.test(given[2]));
      const needed = ["EXT_color_buffer_float", ...(filtered ? ["OES_texture_float_linear"] : [])];
      const lacking = needed.find((name) => !extensions[name]);
      if (lacking) return { lacks: `this browser has no ${lacking}` };
      const refused = [];
      for (const call of calls) {
        const result = run(bound(data, call));
        if (call[0] === "link" && result) refused.push(result[1]);
      }
      if (refused.length) return { lacks: `this browser refuses a shader: ${refused[0]}` };
      const frame = repeated(calls).map((call) => bound(data, call));
      const draw = () => frame.reduce((last, call) => (call[1] < 0 ? run(call) : (run(call), last)), null);
      // Each uniform that has an effect and is no array, with its numbers where they stand.
      const names = new Map(calls.filter(([name]) => name === "locate")
        .map(([, , [, number, words]]) => [number, words[0]]));
      const uniforms = calls.flatMap(([name, , given]) => {
        const [, matrix, count, letter] = /^uniform(Matrix)?(\d)(f|i|ui)v$/.exec(name) ?? [];
        const size = matrix ? count ** 2 : Number(count);
        const called = letter && names.get(given[0].object);
        if (!called || called.startsWith("shaderlab_") || !objects.get(given[0].object)
          || given.at(-1).count !== size) return [];
        return [{ name: called, matrix, whole: letter !== "f", now: argument(given.at(-1), data) }];
      });
      const lose = () => extensions.WEBGL_lose_context?.loseContext();
      return { draw, uniforms, errors, lose };
    },
  };
};
