// SPDX-License-Identifier: MIT
"use strict";
(() => {
  const box = document.getElementById("replay-view");
  const heads = [...document.querySelectorAll("script.replay-head")];
  const payloads = [...document.querySelectorAll("script.replay-bytes")];
  const NONE = -32768, WORST = 8, FAR_CM = 12;
  const SENSOR_COLOURS = [0x9fb4d6, 0xd6b49f, 0xa3cfa8, 0xcfa3c6, 0xc9c59a, 0x9accc9, 0xbdaee0, 0xd0a0a0];

  const inflated = (base64) => {
    const packed = Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
    return new Response(new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"))).arrayBuffer();
  };

  // Channels are differences from instant to instant; what comes out is indexed [channel * instants + instant].
  const unpack = async (text, head) => {
    const buffer = await inflated(text);
    const n = head.instants, kinect = head.skeleton.names.length;
    const counts = [head.sensors.length * kinect * 3, head.joints.length * 3, head.joints.length * head.methods.length * 3];
    let at = 0;
    const [bodies, truth, estimates] = counts.map((channels) => {
      const values = new Int16Array(buffer, at, channels * n);
      for (let c = 0; c < channels; ++c) for (let i = c * n + 1; i < (c + 1) * n; ++i) values[i] += values[i - 1];
      at += channels * n * 2;
      return values;
    });
    const states = new Uint8Array(buffer, at, head.sensors.length * kinect * n);
    for (let c = 0; c < states.length / n; ++c) for (let i = c * n + 1; i < (c + 1) * n; ++i) states[i] += states[i - 1];
    return { bodies, truth, estimates, states };
  };

  const make = (tag, properties = {}, ...children) => {
    const element = Object.assign(document.createElement(tag), properties);
    element.append(...children);
    return element;
  };
  const css = (colour) => `#${colour.toString(16).padStart(6, "0")}`;
  const spaced = (name) => name.replaceAll("_", " ");

  // The nearest joint above in the skeleton that is evaluated, too.
  const bonesOf = (head) => {
    const { names, parents } = head.skeleton, bones = [];
    head.joints.forEach((joint, j) => {
      for (let up = parents[names.indexOf(joint)]; up >= 0; up = parents[up]) {
        const parent = head.joints.indexOf(names[up]);
        if (parent >= 0) { bones.push([parent, j]); break; }
      }
    });
    return bones;
  };

  const player = (T, head, data, view) => {
    const n = head.instants, joints = head.joints.length, methods = head.methods.length;
    const point = (values, channel, i) => values[channel * n + i] !== NONE;
    const truthAt = (j) => j * 3, estimateAt = (j, m) => (j * methods + m) * 3;
    const errorCm = (j, m, i) => {
      const t = truthAt(j), e = estimateAt(j, m);
      if (!point(data.truth, t, i) || !point(data.estimates, e, i)) return NaN;
      let sum = 0;
      for (let k = 0; k < 3; ++k) sum += (data.estimates[(e + k) * n + i] - data.truth[(t + k) * n + i]) ** 2;
      return Math.sqrt(sum) / 10;
    };
    // Of one joint, or the mean of all that are answered.
    const meanErrorCm = (joint, m, i) => {
      if (joint >= 0) return errorCm(joint, m, i);
      let sum = 0, count = 0;
      for (let j = 0; j < joints; ++j) { const e = errorCm(j, m, i); if (e === e) { sum += e; ++count; } }
      return count ? sum / count : NaN;
    };

    const scene = new T.Scene();
    const group = new T.Group();
    scene.add(group);
    const lines = (segments, colour, coloured) => {
      const geometry = new T.BufferGeometry();
      geometry.setAttribute("position", new T.BufferAttribute(new Float32Array(segments * 6), 3));
      if (coloured) geometry.setAttribute("color", new T.BufferAttribute(new Float32Array(segments * 6), 3));
      const object = new T.LineSegments(geometry, new T.LineBasicMaterial(
        coloured ? { vertexColors: T.VertexColors ?? true } : { color: colour }));
      object.frustumCulled = false;
      group.add(object);
      return object;
    };
    const grid = new T.GridHelper(8, 16, 0x4a5261, 0x2a303b);
    group.add(grid);

    const label = (text, colour) => {
      const canvas = make("canvas", { width: 128, height: 32 }), pen = canvas.getContext("2d");
      pen.font = "600 26px sans-serif";
      pen.textAlign = "center";
      pen.fillStyle = css(colour);
      pen.fillText(text, 64, 25);
      const sprite = new T.Sprite(new T.SpriteMaterial({ map: new T.CanvasTexture(canvas), transparent: true, depthTest: false }));
      sprite.scale.set(0.5, 0.125, 1);
      return sprite;
    };
    const sensors = head.sensors.map((sensor, s) => {
      const colour = SENSOR_COLOURS[s % SENSOR_COLOURS.length], holder = new T.Group();
      holder.position.fromArray(sensor.position_m);
      holder.quaternion.fromArray(sensor.quaternion);
      const [near, far] = head.range_m, [w, h] = head.view_deg.map((deg) => Math.tan(deg * Math.PI / 360));
      const corner = (z, x, y) => [x * w * z, y * h * z, z], at = [], signs = [[-1, -1], [1, -1], [1, 1], [-1, 1]];
      signs.forEach(([x, y], k) => {
        const [u, v] = signs[(k + 1) % 4];
        at.push(...corner(near, x, y), ...corner(far, x, y), ...corner(near, x, y), ...corner(near, u, v), ...corner(far, x, y), ...corner(far, u, v));
      });
      const geometry = new T.BufferGeometry();
      geometry.setAttribute("position", new T.BufferAttribute(new Float32Array(at), 3));
      const frustum = new T.LineSegments(geometry, new T.LineBasicMaterial({ color: colour, transparent: true, opacity: 0.28 }));
      const body = new T.Mesh(new T.BoxGeometry(0.25, 0.066, 0.067), new T.MeshBasicMaterial({ color: colour }));
      const name = label(sensor.name, colour);
      name.position.y = 0.18;
      holder.add(frustum, body, name);
      group.add(holder);
      const { parents } = head.skeleton;
      const bones = parents.map((parent, child) => [parent, child]).filter(([parent]) => parent >= 0);
      return { colour, frustum, skeleton: lines(bones.length, 0, true), bones, shown: true };
    });

    const evaluated = bonesOf(head);
    const truthMaterial = new T.MeshBasicMaterial({ color: 0xffffff });
    const ball = new T.SphereGeometry(0.028, 12, 8), rod = new T.CylinderGeometry(0.014, 0.014, 1, 8);
    const meshes = (count, shape) => Array.from({ length: count }, () => {
      const mesh = new T.Mesh(shape, truthMaterial);
      group.add(mesh);
      return mesh;
    });
    const truthBalls = meshes(joints, ball), truthRods = meshes(evaluated.length, rod);

    const first = Math.max(0, head.methods.indexOf("nonlinear"));
    const shownFirst = new Set([first, head.methods.indexOf("mean")]);
    const tracks = head.methods.map((name, m) => ({ name, colour: parseInt(head.colours[m].slice(1), 16), shown: shownFirst.has(m) }));
    const build = (track) => {
      if (track.bones) return;
      track.bones = lines(Math.max(1, evaluated.length), track.colour, false);
      track.errors = lines(joints, 0, true);
      const geometry = new T.BufferGeometry();
      geometry.setAttribute("position", new T.BufferAttribute(new Float32Array(joints * 3), 3));
      track.points = new T.Points(geometry, new T.PointsMaterial({ color: track.colour, size: 0.05 }));
      track.points.frustumCulled = false;
      group.add(track.points);
    };

    // Copies a point of `values` in metres into `to`; false where there is none.
    const copy = (values, channel, i, to, offset) => {
      const there = values[channel * n + i] !== NONE;
      for (let k = 0; k < 3; ++k) to[offset + k] = there ? values[(channel + k) * n + i] / 1000 : 0;
      return there;
    };
    const zero = (to, offset, count) => to.fill(0, offset, offset + count);
    const heat = (cm, to, offset) => {
      const x = Math.min(1, cm / FAR_CM), low = x < 0.5, s = low ? 2 * x : 2 * x - 1;
      const [a, b] = low ? [[0.34, 0.71, 0.91], [1, 0.88, 0.4]] : [[1, 0.88, 0.4], [1, 0.3, 0.2]];
      for (let k = 0; k < 3; ++k) to[offset + k] = to[offset + 3 + k] = a[k] + s * (b[k] - a[k]);
    };

    const drawSensor = (sensor, s, i) => {
      sensor.skeleton.visible = sensor.frustum.visible = sensor.shown;
      if (!sensor.shown) return;
      const kinect = head.skeleton.names.length, { position, color } = sensor.skeleton.geometry.attributes;
      const red = (sensor.colour >> 16) / 255, green = (sensor.colour >> 8 & 255) / 255, blue = (sensor.colour & 255) / 255;
      sensor.bones.forEach(([parent, child], b) => {
        const a = s * kinect + parent, c = s * kinect + child;
        const both = copy(data.bodies, a * 3, i, position.array, b * 6) & copy(data.bodies, c * 3, i, position.array, b * 6 + 3);
        if (!both) zero(position.array, b * 6, 6);
        const bright = data.states[a * n + i] === 2 && data.states[c * n + i] === 2 ? 0.85 : 0.35;
        for (let v = 0; v < 2; ++v) {
          color.array[b * 6 + v * 3] = bright * red;
          color.array[b * 6 + v * 3 + 1] = bright * green;
          color.array[b * 6 + v * 3 + 2] = bright * blue;
        }
      });
      position.needsUpdate = color.needsUpdate = true;
    };
    const up = new T.Vector3(0, 1, 0), from = new T.Vector3(), to = new T.Vector3(), six = new Float32Array(6);
    const drawTruth = (i, joint) => {
      truthBalls.forEach((mesh, j) => {
        mesh.visible = copy(data.truth, truthAt(j), i, six, 0);
        mesh.position.fromArray(six);
        mesh.scale.setScalar(joint === j ? 1.7 : 1);
      });
      truthRods.forEach((mesh, b) => {
        const [parent, child] = evaluated[b];
        mesh.visible = Boolean(copy(data.truth, truthAt(parent), i, six, 0) & copy(data.truth, truthAt(child), i, six, 3));
        from.fromArray(six);
        to.fromArray(six, 3).sub(from);
        mesh.position.copy(from).addScaledVector(to, 0.5);
        mesh.scale.set(1, Math.max(1e-6, to.length()), 1);
        mesh.quaternion.setFromUnitVectors(up, to.normalize());
      });
    };
    const drawTrack = (track, m, i) => {
      if (track.shown) build(track);
      if (!track.bones) return;
      for (const part of [track.bones, track.errors, track.points]) part.visible = track.shown;
      if (!track.shown) return;
      const bones = track.bones.geometry.attributes.position, points = track.points.geometry.attributes.position;
      const { position, color } = track.errors.geometry.attributes;
      evaluated.forEach(([parent, child], b) => {
        const both = copy(data.estimates, estimateAt(parent, m), i, bones.array, b * 6) &
          copy(data.estimates, estimateAt(child, m), i, bones.array, b * 6 + 3);
        if (!both) zero(bones.array, b * 6, 6);
      });
      for (let j = 0; j < joints; ++j) {
        if (!copy(data.estimates, estimateAt(j, m), i, points.array, j * 3)) points.array[j * 3 + 1] = -99;
        const cm = errorCm(j, m, i);
        zero(position.array, j * 6, 6);
        if (!(cm === cm)) continue;
        copy(data.truth, truthAt(j), i, position.array, j * 6);
        copy(data.estimates, estimateAt(j, m), i, position.array, j * 6 + 3);
        heat(cm, color.array, j * 6);
      }
      bones.needsUpdate = points.needsUpdate = position.needsUpdate = color.needsUpdate = true;
    };

    // Peaks of a method's error, half a second apart at least.
    const worst = (joint, m) => {
      const apart = Math.max(1, Math.round(0.5 * (n - 1) / (head.span_s || 1))), found = [];
      const order = Array.from({ length: n }, (_, i) => [meanErrorCm(joint, m, i), i]).filter(([e]) => e === e).sort((a, b) => b[0] - a[0]);
      for (const [cm, i] of order) {
        if (found.length === WORST) break;
        if (found.every(([, other]) => Math.abs(other - i) >= apart)) found.push([cm, i]);
      }
      return found;
    };
    // Where the person is, in the mean.
    const middle = new T.Vector3(0, 1, 0);
    {
      let count = 0;
      const sum = new T.Vector3();
      for (let i = 0; i < n; i += 15) for (let j = 0; j < joints; ++j)
        if (copy(data.truth, truthAt(j), i, six, 0)) { sum.add(from.fromArray(six)); ++count; }
      if (count) middle.copy(sum.divideScalar(count));
    }
    return { scene, sensors, tracks, first, worst, meanErrorCm, middle, draw: (i, joint) => {
      sensors.forEach((sensor, s) => drawSensor(sensor, s, i));
      drawTruth(i, joint);
      tracks.forEach((track, m) => drawTrack(track, m, i));
      view.render(scene);
    } };
  };

  // A camera that turns about a point: drag, wheel or pinch; shift or right button moves the point.
  const orbit = (T, stage, redraw) => {
    const camera = new T.PerspectiveCamera(45, 1, 0.05, 60), target = new T.Vector3(0, 1, 0);
    const state = { distance: 3.6, azimuth: 0.7, elevation: 0.32 }, pointers = new Map();
    const place = () => {
      const flat = Math.cos(state.elevation) * state.distance;
      camera.position.set(target.x + flat * Math.sin(state.azimuth), target.y + state.distance * Math.sin(state.elevation),
        target.z + flat * Math.cos(state.azimuth));
      camera.lookAt(target);
      redraw();
    };
    const zoom = (factor) => { state.distance = Math.min(20, Math.max(0.6, state.distance * factor)); place(); };
    const turn = (dx, dy) => {
      state.azimuth -= dx * 0.008;
      state.elevation = Math.min(1.5, Math.max(-0.4, state.elevation + dy * 0.008));
      place();
    };
    const move = (dx, dy) => {
      const scale = state.distance * 0.0012, right = new T.Vector3().setFromMatrixColumn(camera.matrix, 0);
      target.addScaledVector(right, -dx * scale).addScaledVector(new T.Vector3().setFromMatrixColumn(camera.matrix, 1), dy * scale);
      place();
    };
    stage.addEventListener("contextmenu", (event) => event.preventDefault());
    stage.addEventListener("pointerdown", (event) => { stage.setPointerCapture(event.pointerId); pointers.set(event.pointerId, event); });
    for (const type of ["pointerup", "pointercancel"]) stage.addEventListener(type, (event) => pointers.delete(event.pointerId));
    stage.addEventListener("pointermove", (event) => {
      const before = pointers.get(event.pointerId);
      if (!before) return;
      const dx = event.clientX - before.clientX, dy = event.clientY - before.clientY;
      if (pointers.size === 2) {
        const [other] = [...pointers.values()].filter((p) => p.pointerId !== event.pointerId);
        const span = (p) => Math.hypot(p.clientX - other.clientX, p.clientY - other.clientY);
        zoom(span(before) / Math.max(1, span(event)));
        move(dx / 2, dy / 2);
      } else if (event.shiftKey || (event.buttons & 2)) {
        move(dx, dy);
      } else {
        turn(dx, dy);
      }
      pointers.set(event.pointerId, event);
    });
    stage.addEventListener("wheel", (event) => {
      if (document.activeElement !== stage && !event.ctrlKey) return;  // the page scrolls past a view that is not in use
      event.preventDefault();
      zoom(Math.exp(event.deltaY * 0.001));
    }, { passive: false });
    return { camera, zoom, aim: (point) => { target.copy(point); place(); } };
  };

  const start = async () => {
    const library = new TextDecoder().decode(await inflated(document.getElementById("three-js").textContent));
    document.head.append(make("script", { textContent: library }));
    const T = window.THREE, overlay = make("div", { className: "overlay" });
    const stage = make("div", { className: "stage", tabIndex: 0 }, overlay);
    stage.setAttribute("role", "group");
    stage.setAttribute("aria-label", "3-D view. Space plays, arrow keys step, plus and minus or the wheel zoom, dragging turns.");
    let renderer;
    try { renderer = new T.WebGLRenderer({ antialias: true }); } catch { return; }
    renderer.setClearColor(0x101319);
    renderer.setPixelRatio(Math.min(2, devicePixelRatio));
    stage.prepend(renderer.domElement);

    const play = make("button", { type: "button", textContent: "Play" });
    const slider = make("input", { type: "range", min: 0, value: 0, step: 1 });
    slider.setAttribute("aria-label", "Instant");
    const select = (label, options) => {
      const list = make("select", {}, ...options.map(([value, text]) => make("option", { value, textContent: text })));
      return [list, make("label", {}, label + " ", list)];
    };
    const [speed, speedLabel] = select("Speed", [[0.25, "¼"], [0.5, "½"], [1, "1"], [2, "2"], [4, "4"]]);
    speed.value = 1;
    const [which, whichLabel] = select("Take", heads.map((head, k) => [k, head.dataset.title]));
    const joint = make("select"), jointLabel = make("label", {}, "Joint ", joint);
    const methodField = make("fieldset"), sensorField = make("fieldset"), worstField = make("fieldset");
    box.replaceChildren(make("div", { className: "strip" }, whichLabel, jointLabel), stage,
      make("div", { className: "strip" }, play, slider, speedLabel),
      make("p", { className: "scale" }, "Error: 0", make("span"), `${FAR_CM} cm and more`),
      make("div", { className: "columns" }, methodField, worstField, sensorField));

    let now = null, head = null, instant = 0, playing = false, last = 0, due = false, ranked = 0;
    const draw = () => { due = false; if (now) now.draw(instant, Number(joint.value)); };
    const redraw = () => { if (!due) { due = true; requestAnimationFrame(draw); } };
    const view = orbit(T, stage, redraw);
    view.render = (scene) => renderer.render(scene, view.camera);
    const seconds = (i) => (head.instants < 2 ? 0 : i * head.span_s / (head.instants - 1));
    const centimetres = (cm) => (cm === cm ? `${cm.toFixed(1)} cm` : "no answer");

    const readout = () => {
      const j = Number(joint.value), name = j < 0 ? "mean of all joints" : spaced(head.joints[j]);
      overlay.replaceChildren(make("b", { textContent: head.simulated ? "simulated" : "recorded" }),
        ` ${head.condition}, take ${head.take}`, make("br"), `${seconds(instant).toFixed(2)} of ${head.span_s.toFixed(1)} s, ${name}`);
      now.tracks.forEach((track, m) => {
        const text = centimetres(now.meanErrorCm(j, m, instant));
        track.output.textContent = text;
        if (track.shown) overlay.append(make("br"), Object.assign(make("span", { textContent: `${track.name}: ${text}` }), { style: `color:${css(track.colour)}` }));
      });
    };
    const go = (i) => {
      instant = Math.min(head.instants - 1, Math.max(0, i));
      slider.value = instant;
      slider.setAttribute("aria-valuetext", `${seconds(instant).toFixed(2)} s`);
      readout();
      redraw();
    };
    const rank = () => {
      const name = head.methods[ranked], list = make("ol");
      for (const [cm, i] of now.worst(Number(joint.value), ranked)) {
        const jump = make("button", { type: "button", textContent: `${seconds(i).toFixed(2)} s: ${cm.toFixed(1)} cm` });
        jump.addEventListener("click", () => { stop(); go(i); });
        list.append(make("li", {}, jump));
      }
      worstField.replaceChildren(make("legend", { textContent: `Worst instants of ${name}` }), list);
    };
    const row = (field, entry, name, colour, changed) => {
      const check = make("input", { type: "checkbox", checked: entry.shown });
      const key = Object.assign(make("span", { className: "key" }), { style: `background:${css(colour)}` });
      entry.output = make("output");
      check.addEventListener("change", () => { entry.shown = check.checked; changed(); });
      field.append(make("label", { className: "row" }, check, key, name, entry.output));
    };
    const tick = (time) => {
      if (!playing) return;
      const step = (time - last) / 1000 * Number(speed.value) * (head.instants - 1) / (head.span_s || 1);
      if (step >= 1) {
        last = time;
        if (instant >= head.instants - 1) { stop(); return; }
        go(instant + Math.floor(step));
      }
      requestAnimationFrame(tick);
    };
    const stop = () => { playing = false; play.textContent = "Play"; };
    const toggle = () => {
      playing = !playing;
      play.textContent = playing ? "Pause" : "Play";
      if (!playing) return;
      if (instant >= head.instants - 1) go(0);
      last = performance.now();
      requestAnimationFrame(tick);
    };

    const loaded = new Map();
    const load = async (k) => {
      stop();
      head = JSON.parse(heads[k].textContent);
      if (!loaded.has(k)) loaded.set(k, player(T, head, await unpack(payloads[k].textContent, head), view));
      now = loaded.get(k);
      slider.max = head.instants - 1;
      joint.replaceChildren(make("option", { value: -1, textContent: "all" }),
        ...head.joints.map((name, j) => make("option", { value: j, textContent: spaced(name) })));
      ranked = now.first;
      methodField.replaceChildren(make("legend", { textContent: "Methods" }));
      methodField.append(make("label", { className: "row" },
        Object.assign(make("span", { className: "key" }), { style: "background:#fff;outline:1px solid #888;height:.45em" }), "truth"));
      now.tracks.forEach((track, m) => row(methodField, track, track.name, track.colour, () => {
        if (track.shown) ranked = m;
        rank();
        readout();
        redraw();
      }));
      sensorField.replaceChildren(make("legend", { textContent: "Sensors" }));
      now.sensors.forEach((sensor, s) => row(sensorField, sensor, head.sensors[s].name, sensor.colour, redraw));
      rank();
      view.aim(now.middle);
      go(0);
    };

    play.addEventListener("click", toggle);
    slider.addEventListener("input", () => { stop(); go(Number(slider.value)); });
    joint.addEventListener("change", () => { rank(); readout(); redraw(); });
    which.addEventListener("change", () => load(Number(which.value)));
    stage.addEventListener("keydown", (event) => {
      const second = Math.round((head.instants - 1) / (head.span_s || 1)), step = event.shiftKey ? second : 1;
      const keys = { " ": toggle, ArrowRight: () => go(instant + step), ArrowLeft: () => go(instant - step), Home: () => go(0),
        End: () => go(head.instants - 1), "+": () => view.zoom(0.9), "-": () => view.zoom(1.1) };
      if (!keys[event.key]) return;
      event.preventDefault();
      keys[event.key]();
    });
    new ResizeObserver(() => {
      const { clientWidth: width, clientHeight: height } = stage;
      if (!width || !height) return;
      renderer.setSize(width, height, false);
      view.camera.aspect = width / height;
      view.camera.updateProjectionMatrix();
      redraw();
    }).observe(stage);
    await load(0);
    box.dataset.ready = "true";
  };

  // Only when it comes into view: most readers of the tables never start it.
  const seen = new IntersectionObserver((entries) => {
    if (!entries.some((entry) => entry.isIntersecting)) return;
    seen.disconnect();
    start().catch((error) => { box.replaceChildren(make("p", { textContent: `The replay cannot be shown: ${error.message}` })); console.error(error); });
  }, { rootMargin: "200px" });
  seen.observe(box);
})();
