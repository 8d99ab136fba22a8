/**
 * Draws a robot in space by WebGL, without any library. World axes: x along the first heading, y to its left, z up; lengths in m.
 * `viewInSpace(canvas, colors)` gives null where there is no WebGL 2.
 */
function viewInSpace(canvas, colors) {
  const gl = canvas.getContext("webgl2", { antialias: true, stencil: true, alpha: false });
  if (!gl) return null;

  // --- vectors, quaternions w, x, y, z and matrices by columns ---------------------------------------------------------------

  const sum = (a, b, share = 1) => [a[0] + share * b[0], a[1] + share * b[1], a[2] + share * b[2]];
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const unit = a => { const length = Math.hypot(...a) || 1; return a.map(x => x / length); };
  /** Two unit vectors across `d`. */
  function across(d) {
    const u = unit(cross(d, Math.abs(d[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0]));
    return [u, cross(d, u)];
  }
  function product(a, b) {
    const c = new Float32Array(16);
    for (let column = 0; column < 4; column++)
      for (let row = 0; row < 4; row++)
        for (let k = 0; k < 4; k++) c[4 * column + row] += a[4 * k + row] * b[4 * column + k];
    return c;
  }
  function perspective(angle, aspect, near, far) {
    const f = 1 / Math.tan(angle / 2), d = near - far;
    return new Float32Array([f / aspect, 0, 0, 0, 0, f, 0, 0, 0, 0, (far + near) / d, -1, 0, 0, 2 * far * near / d, 0]);
  }
  function lookAt(eye, target) {
    const back = unit(sum(eye, target, -1)), right = unit(cross([0, 0, 1], back)), up = cross(back, right);
    return new Float32Array([right[0], up[0], back[0], 0, right[1], up[1], back[1], 0, right[2], up[2], back[2], 0, -dot(right, eye), -dot(up, eye), -dot(back, eye), 1]);
  }
  const frame = (u, v, w, at) => new Float32Array([...u, 0, ...v, 0, ...w, 0, ...at, 1]);
  const times = (a, s) => [a[0] * s, a[1] * s, a[2] * s];

  // --- programs and shapes -------------------------------------------------------------------------------------------------

  function program(vertex, fragment) {
    const it = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, "#version 300 es\nprecision highp float;\n" + text);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
      gl.attachShader(it, shader);
    }
    gl.bindAttribLocation(it, 0, "place");
    gl.bindAttribLocation(it, 1, "normal");
    gl.linkProgram(it);
    if (!gl.getProgramParameter(it, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(it));
    const at = {}, count = gl.getProgramParameter(it, gl.ACTIVE_UNIFORMS);
    for (let k = 0; k < count; k++) { const { name } = gl.getActiveUniform(it, k); at[name] = gl.getUniformLocation(it, name); }
    return { it, at };
  }

  const solid = program(
    "in vec3 place; in vec3 normal; uniform mat4 sight, model; out vec3 n; out vec3 where;\n" +
    "void main() { vec4 world = model * vec4(place, 1.0); where = world.xyz; n = mat3(model) * normal; gl_Position = sight * world; }",
    "in vec3 n; in vec3 where; uniform vec4 color; uniform vec3 light, eye; uniform float flatly; out vec4 shown;\n" +
    "void main() {\n" +
    "  vec3 m = normalize(n), v = normalize(eye - where); if (dot(m, v) < 0.0) m = -m;\n" +
    "  float lit = 0.72 + 0.3 * max(dot(m, light), 0.0) - 0.14 * max(-m.z, 0.0);\n" +
    "  float gloss = 0.18 * pow(max(dot(reflect(-light, m), v), 0.0), 24.0);\n" +
    "  shown = vec4(mix(color.rgb * lit + gloss, color.rgb, flatly), color.a);\n" +
    "}");
  // The ground has a line each 0.5 m, a thicker one each 5 m, and fades into the paper.
  const ground = program(
    "in vec3 place; uniform mat4 sight; uniform vec3 middle; uniform float slope; out vec2 xy, from;\n" +
    "void main() { from = place.xy * 60.0; vec3 at = vec3(middle.xy + from, 0.0); at.z = at.x * slope; xy = at.xy; gl_Position = sight * vec4(at, 1.0); }",
    "in vec2 xy, from; uniform vec4 color, line, paper; out vec4 shown;\n" +
    "float grid(float step, float width) { vec2 p = xy / step, d = fwidth(p); vec2 near = abs(fract(p - 0.5) - 0.5) / max(d, 1e-6) - width; vec2 lies = clamp(1.0 - near, 0.0, 1.0) * clamp(1.5 - 3.0 * d, 0.0, 1.0); return max(lies.x, lies.y); }\n" +
    "void main() { vec3 c = mix(color.rgb, line.rgb, max(0.4 * grid(0.5, 0.0), 0.7 * grid(5.0, 0.5))); shown = vec4(mix(c, paper.rgb, smoothstep(6.0, 45.0, length(from))), 1.0); }");
  // A ribbon on the ground; `normal` has the length along it (m) for dashes.
  const ribbon = program(
    "in vec3 place; in vec3 normal; uniform mat4 sight; out float along; void main() { along = normal.x; gl_Position = sight * vec4(place, 1.0); }",
    "in float along; uniform vec4 color; uniform float dash; out vec4 shown; void main() { if (dash > 0.0 && fract(along / dash) > 0.5) discard; shown = color; }");

  function shape(places, normals, indices) {
    const array = gl.createVertexArray();
    gl.bindVertexArray(array);
    [places, normals].forEach((list, k) => {
      gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
      gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(list), gl.STATIC_DRAW);
      gl.enableVertexAttribArray(k);
      gl.vertexAttribPointer(k, 3, gl.FLOAT, false, 0, 0);
    });
    if (indices) {
      gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
      gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, new Uint16Array(indices), gl.STATIC_DRAW);
    }
    gl.bindVertexArray(null);
    return { array, count: indices ? indices.length : places.length / 3, indexed: Boolean(indices) };
  }
  /** The surface that a line of [radius, height, normal outwards, normal up] sweeps about the z axis. */
  function turnedShape(line, around) {
    const places = [], normals = [], indices = [];
    for (const [r, z, out, up] of line)
      for (let k = 0; k <= around; k++) {
        const [s, c] = [Math.sin(2 * Math.PI * k / around), Math.cos(2 * Math.PI * k / around)];
        places.push(r * c, r * s, z);
        normals.push(out * c, out * s, up);
      }
    for (let row = 0; row + 1 < line.length; row++)
      for (let k = 0; k < around; k++) {
        const a = row * (around + 1) + k, b = a + around + 1;
        indices.push(a, a + 1, b, b, a + 1, b + 1);
      }
    return shape(places, normals, indices);
  }
  function roundShape(rows) {
    const line = [];
    for (let k = 0; k <= rows; k++) { const a = Math.PI * (k / rows - 0.5); line.push([Math.cos(a), Math.sin(a), Math.cos(a), Math.sin(a)]); }
    return turnedShape(line, 2 * rows - 4);
  }
  const shapes = {
    ball: roundShape(16),
    // Feet are small, and many.
    foot: roundShape(7),
    rod: turnedShape([[0, 0, 0, -1], [1, 0, 0, -1], [1, 0, 1, 0], [1, 1, 1, 0], [1, 1, 0, 1], [0, 1, 0, 1]], 10),
    cone: turnedShape([[0, 0, 0, -1], [1, 0, 0, -1], [1, 0, 0.8, 0.6], [0, 1, 0.8, 0.6]], 16),
    ring: turnedShape([[0.9, 0, 0, 1], [1, 0, 0, 1]], 64),
    plate: turnedShape([[0, 0, 0, 1], [1, 0, 0, 1]], 64),
    square: shape([-1, -1, 0, 1, -1, 0, -1, 1, 0, 1, 1, 0], new Array(12).fill(0)),
  };

  // --- drawing -------------------------------------------------------------------------------------------------------------

  const light = unit([0.35, 0.5, 1]);
  const ANGLE = 0.7;
  const camera = { yaw: -2.2, pitch: 0.32, distance: 1.9, target: [0, 0, 0.2] };
  let slope = 0, ribbons = [], sight = null, eye = [0, 0, 0];

  function paint(it, model, color, flatly = 0) {
    gl.uniformMatrix4fv(solid.at.model, false, model);
    gl.uniform4fv(solid.at.color, color);
    gl.uniform1f(solid.at.flatly, flatly);
    gl.bindVertexArray(it.array);
    gl.drawElements(gl.TRIANGLES, it.count, gl.UNSIGNED_SHORT, 0);
  }
  const along = (d, length, radius, at) => { const [u, v] = across(d); return frame(times(u, radius), times(v, radius), times(d, length), at); };
  const ballAt = (at, radius) => frame([radius, 0, 0], [0, radius, 0], [0, 0, radius], at);

  /** What falls on the ground along the light. */
  function shadowOf() {
    const n = unit([-slope, 0, 1]), d = dot(n, light), m = new Float32Array(16);
    for (let column = 0; column < 4; column++)
      for (let row = 0; row < 3; row++) {
        const same = row === column ? 1 : 0;
        m[4 * column + row] = column < 3 ? same - light[row] * n[column] / d : 0;
      }
    m[15] = 1;
    return m;
  }

  /** Shapes of a robot: [shape, model, colour]. Feet have the colour of their force, barrels and rods that of their valve. */
  function parts(robot, ghost) {
    const list = [[shapes.ball, ballAt(robot.place, robot.hub), ghost ?? colors.hub]];
    for (const leg of robot.legs) {
      const tip = sum(robot.place, leg.direction, robot.radius + leg.extension);
      const top = robot.radius - robot.rodLength, open = leg.open ? colors.force : null;
      if (top > robot.hub) list.push([shapes.rod, along(leg.direction, top - robot.hub, 1.9 * robot.rodRadius, sum(robot.place, leg.direction, robot.hub)), ghost ?? open ?? colors.metal]);
      const from = Math.max(robot.hub, top + leg.extension);
      list.push([shapes.rod, along(leg.direction, robot.radius + leg.extension - from, robot.rodRadius, sum(robot.place, leg.direction, from)), ghost ?? open ?? colors.ink]);
      list.push([shapes.foot, ballAt(sum(tip, leg.direction, -robot.footRadius), robot.footRadius), ghost ?? leg.color]);
    }
    return list;
  }

  function solids(list, flatly) { for (const [it, model, color] of list) paint(it, model, color, flatly); }

  function drawShadow(list) {
    const fall = shadowOf(), shade = [0, 0, 0, 0.28];
    gl.enable(gl.STENCIL_TEST);
    gl.stencilFunc(gl.EQUAL, 0, 255);
    gl.stencilOp(gl.KEEP, gl.KEEP, gl.INCR);
    for (const [it, model] of list) paint(it, product(fall, model), shade, 1);
    gl.disable(gl.STENCIL_TEST);
  }

  function useSolid() {
    gl.useProgram(solid.it);
    gl.uniformMatrix4fv(solid.at.sight, false, sight);
    gl.uniform3fv(solid.at.light, light);
    gl.uniform3fv(solid.at.eye, eye);
  }

  function drawGround() {
    gl.useProgram(ground.it);
    gl.uniformMatrix4fv(ground.at.sight, false, sight);
    gl.uniform3fv(ground.at.middle, camera.target);
    gl.uniform1f(ground.at.slope, slope);
    gl.uniform4fv(ground.at.color, colors.ground);
    gl.uniform4fv(ground.at.line, colors.turf);
    gl.uniform4fv(ground.at.paper, colors.paper);
    gl.bindVertexArray(shapes.square.array);
    gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
  }

  function drawRibbons(k) {
    gl.useProgram(ribbon.it);
    gl.uniformMatrix4fv(ribbon.at.sight, false, sight);
    for (const one of ribbons) {
      if (one.hidden) continue;
      const count = one.whole ? one.it.count : Math.min(one.it.count, 2 * (k + 1));
      gl.uniform4fv(ribbon.at.color, one.color);
      gl.uniform1f(ribbon.at.dash, one.dash);
      gl.bindVertexArray(one.it.array);
      gl.drawArrays(gl.TRIANGLE_STRIP, 0, count);
    }
  }

  function drawArrows(robot) {
    for (const leg of robot.legs) {
      const size = Math.hypot(...leg.force);
      if (size === 0) continue;
      const d = times(leg.force, 1 / size), length = 0.3 * Math.sqrt(size / robot.mostForce), head = Math.min(0.045, 0.5 * length);
      const foot = sum(robot.place, leg.direction, robot.radius + leg.extension);
      // Thicker than a rod, along which most forces are, and seen through, as its colour says whether its valve is open.
      paint(shapes.rod, along(d, length - head, 1.3 * robot.rodRadius, foot), [...colors.accent.slice(0, 3), 0.55]);
      paint(shapes.cone, along(d, head, 2.6 * robot.rodRadius, sum(foot, d, length - head)), [...colors.accent.slice(0, 3), 0.8]);
    }
  }

  function drawDisc(robot) {
    const [u, v] = across(robot.axis), size = 1.02 * robot.radius, model = frame(times(u, size), times(v, size), robot.axis, robot.place);
    gl.depthMask(false);
    paint(shapes.plate, model, [...colors.accent.slice(0, 3), 0.1], 1);
    paint(shapes.ring, model, [...colors.accent.slice(0, 3), 0.35], 1);
    gl.depthMask(true);
  }

  // Where pictures take too long, as without a graphics card, they get fewer pixels: 30 a second are wanted.
  let sharpness = 1, usual = 0;
  const SLOW = 1 / 33, BLURRED = 0.4;
  /** Notes that a picture took so long (s). */
  function took(seconds) {
    usual = usual ? usual + 0.15 * (Math.min(seconds, 0.3) - usual) : seconds;
    if (usual > SLOW && sharpness > BLURRED) { sharpness = Math.max(BLURRED, 0.85 * sharpness); usual = 0.7 * SLOW; }
  }

  function fit() {
    const ratio = sharpness * Math.min(devicePixelRatio || 1, 2), width = Math.max(1, Math.round(canvas.clientWidth * ratio)), height = Math.max(1, Math.round(canvas.clientHeight * ratio));
    if (canvas.width !== width || canvas.height !== height) { canvas.width = width; canvas.height = height; }
  }

  /** Draws `scene`: `robot`, `ghost` and `disc` where they are shown, ribbons up to point `k`. */
  function draw(scene) {
    fit();
    const { yaw, pitch, distance, target } = camera;
    eye = sum(target, [Math.cos(pitch) * Math.cos(yaw), Math.cos(pitch) * Math.sin(yaw), Math.sin(pitch)], distance);
    eye[2] = Math.max(eye[2], slope * eye[0] + 0.03);
    sight = product(perspective(ANGLE, canvas.width / canvas.height, 0.02 * Math.max(distance, 0.5), 150), lookAt(eye, target));
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clearColor(...colors.paper);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT | gl.STENCIL_BUFFER_BIT);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
    // What lies on the ground is painted upon it without depths, which at a slant are too coarse for a millimetre; then the
    // ground gets its depth, for what reaches below it.
    gl.disable(gl.DEPTH_TEST);
    drawGround();
    drawRibbons(scene.k);
    useSolid();
    const list = parts(scene.robot);
    drawShadow(list);
    gl.enable(gl.DEPTH_TEST);
    gl.colorMask(false, false, false, false);
    drawGround();
    gl.colorMask(true, true, true, true);
    useSolid();
    solids(list, 0);
    drawArrows(scene.robot);
    if (scene.ghost) {
      gl.depthMask(false);
      solids(parts(scene.ghost, [...colors.planned.slice(0, 3), 0.28]), 0.4);
      gl.depthMask(true);
    }
    if (scene.disc) drawDisc(scene.robot);
    gl.bindVertexArray(null);
  }

  /** A ribbon of `width` (m) through `places`, x and y of each point, on the ground. */
  function addRibbon(places, { width, color, dash = 0, whole = false }) {
    const points = places.length / 2, at = [], lengths = [];
    let length = 0, left = [0, 1];
    for (let k = 0; k < points; k++) {
      const [x, y] = [places[2 * k], places[2 * k + 1]], next = Math.min(k + 1, points - 1), last = Math.max(k - 1, 0);
      const [dx, dy] = [places[2 * next] - places[2 * last], places[2 * next + 1] - places[2 * last + 1]], step = Math.hypot(dx, dy);
      if (step > 1e-5) left = [-dy / step, dx / step];
      if (k > 0) length += Math.hypot(x - places[2 * k - 2], y - places[2 * k - 1]);
      for (const side of [-0.5, 0.5]) {
        const [u, v] = [x + side * width * left[0], y + side * width * left[1]];
        at.push(u, v, slope * u);
        lengths.push(length, 0, 0);
      }
    }
    const one = { it: shape(at, lengths), color, dash, whole, hidden: false };
    ribbons.push(one);
    return one;
  }

  return {
    camera, draw, addRibbon, took,
    setSlope: tangent => { slope = tangent; },
    /** The picture's pixels, red, green, blue, alpha: in the task that has drawn it. */
    pixels: () => {
      const all = new Uint8Array(4 * canvas.width * canvas.height);
      gl.readPixels(0, 0, canvas.width, canvas.height, gl.RGBA, gl.UNSIGNED_BYTE, all);
      return all;
    },
    /** Waits until all that was drawn is there; an error of WebGL, 0 if there was none. */
    finish: () => {
      gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
      return gl.getError();
    },
  };
}
