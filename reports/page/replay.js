// SPDX-License-Identifier: MIT
// A take in 3-D: the truth, and the estimate of one method.
"use strict";
(() => {
  const box = document.getElementById("replay-view");
  const takes = [...document.querySelectorAll("script.take")];
  const kNone = -32768, kTruth = 0xffffff, kError = 0xffb347;

  const make = (tag, properties = {}, ...children) => {
    const element = Object.assign(document.createElement(tag), properties);
    element.append(...children);
    return element;
  };
  const coloured = (text, colour) => {
    const span = make("span", { textContent: text });
    span.style.color = `#${colour.toString(16).padStart(6, "0")}`;
    return make("div", {}, span);
  };
  const inflated = (base64) => {
    const packed = Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
    return new Response(new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"))).arrayBuffer();
  };

  // The take with point(number, instant): x, y, z in metres, or nothing. Points: the truth of every evaluated joint, then
  // every method's estimates.
  const unpack = async (text) => {
    const take = JSON.parse(text), values = new Int16Array(await inflated(take.points)), n = take.instants;
    for (let i = 0; i < values.length; ++i) if (i % n) values[i] += values[i - 1];
    take.point = (number, instant) => {
      const at = number * 3 * n + instant;
      return values[at] === kNone ? null : [values[at] / 1000, values[at + n] / 1000, values[at + 2 * n] / 1000];
    };
    take.ofMethod = (m) => (m + 1) * take.joints.length;
    return take;
  };

  // Pairs of joints: each with the nearest above it in the skeleton that is there, too.
  const bonesOf = (skeleton, joints) => joints.flatMap((joint, j) => {
    let up = skeleton.parents[skeleton.names.indexOf(joint)];
    while (up >= 0 && !joints.includes(skeleton.names[up])) up = skeleton.parents[up];
    return up < 0 ? [] : [[joints.indexOf(skeleton.names[up]), j]];
  });

  // The mean of the truth's positions, which the camera looks at.
  const middleOf = (take) => {
    const sum = [0, 0, 0];
    let count = 0;
    for (let i = 0; i < take.instants; i += 15)
      for (const point of take.joints.map((_, j) => take.point(j, i)).filter(Boolean)) {
        point.forEach((x, k) => { sum[k] += x; });
        ++count;
      }
    return count ? sum.map((x) => x / count) : [0, 1, 0];
  };

  // The scene of a take; show(instant, method) moves it and says the mean error in centimetres.
  const sceneOf = (T, take) => {
    const scene = new T.Scene();
    scene.add(new T.GridHelper(8, 16, 0x4a5261, 0x2a303b));
    const geometry = (points) => {
      const shape = new T.BufferGeometry();
      shape.setAttribute("position", new T.BufferAttribute(new Float32Array(points * 3), 3));
      return shape;
    };
    const add = (object) => {
      object.frustumCulled = false;
      scene.add(object);
      return object;
    };
    const lines = (count, color) => add(new T.LineSegments(geometry(2 * count), new T.LineBasicMaterial({ color })));
    const dots = (count, color, size) => add(new T.Points(geometry(count), new T.PointsMaterial({ color, size })));
    // Moves the points of an object; where one of a line's ends is missing, no line is drawn.
    const move = (object, points, each) => {
      const position = object.geometry.attributes.position;
      for (let k = 0; k < points.length; k += each) {
        const group = points.slice(k, k + each), there = group.every(Boolean);
        group.forEach((point, e) => position.setXYZ(k + e, ...(there ? point : [0, -99, 0])));
      }
      position.needsUpdate = true;
    };

    const { skeleton, joints } = take;
    const bones = bonesOf(skeleton, joints);
    const truth = { lines: lines(bones.length, kTruth), dots: dots(joints.length, kTruth, 0.07) };
    const estimate = { lines: lines(bones.length, 0), dots: dots(joints.length, 0, 0.05) };
    const errors = lines(joints.length, kError);
    const moveBody = (body, first, i) => {
      move(body.lines, bones.flat().map((joint) => take.point(first + joint, i)), 2);
      move(body.dots, joints.map((_, j) => take.point(first + j, i)), 1);
    };
    return { scene, show: (i, method) => {
      const first = take.ofMethod(method);
      for (const part of Object.values(estimate)) part.material.color.set(take.colours[method]);
      moveBody(truth, 0, i);
      moveBody(estimate, first, i);
      const pairs = joints.map((_, j) => [take.point(j, i), take.point(first + j, i)]);
      move(errors, pairs.flat(), 2);
      const found = pairs.filter(([a, b]) => a && b).map(([a, b]) => 100 * Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]));
      return found.reduce((sum, cm) => sum + cm, 0) / found.length;
    } };
  };

  // A camera that turns about a point: dragging turns, the wheel or two fingers zoom.
  const orbit = (T, stage, changed) => {
    const camera = new T.PerspectiveCamera(45, 1, 0.05, 60), target = new T.Vector3(0, 1, 0), pointers = new Map();
    let distance = 2.6, azimuth = 0.7, elevation = 0.32;
    const place = () => {
      const flat = Math.cos(elevation) * distance;
      camera.position.set(flat * Math.sin(azimuth), distance * Math.sin(elevation), flat * Math.cos(azimuth)).add(target);
      camera.lookAt(target);
      changed();
    };
    const zoom = (factor) => {
      distance = Math.min(20, Math.max(0.6, distance * factor));
      place();
    };
    const span = () => {
      const [a, b] = [...pointers.values()];
      return Math.max(1, Math.hypot(a.clientX - b.clientX, a.clientY - b.clientY));
    };
    stage.addEventListener("pointerdown", (event) => {
      stage.setPointerCapture(event.pointerId);
      pointers.set(event.pointerId, event);
    });
    for (const type of ["pointerup", "pointercancel"])
      stage.addEventListener(type, (event) => pointers.delete(event.pointerId));
    stage.addEventListener("pointermove", (event) => {
      const before = pointers.get(event.pointerId), wide = pointers.size === 2 && span();
      if (!before) return;
      pointers.set(event.pointerId, event);
      if (wide) return zoom(wide / span());
      azimuth -= (event.clientX - before.clientX) * 0.008;
      elevation = Math.min(1.5, Math.max(-0.4, elevation + (event.clientY - before.clientY) * 0.008));
      place();
    });
    stage.addEventListener("wheel", (event) => {
      if (document.activeElement !== stage) return;  // the page scrolls past a view that is not in use
      event.preventDefault();
      zoom(Math.exp(event.deltaY * 0.001));
    }, { passive: false });
    return { camera, zoom, aim: (point) => {
      target.fromArray(point);
      place();
    } };
  };

  const start = async () => {
    const library = new TextDecoder().decode(await inflated(document.getElementById("three-js").textContent));
    document.head.append(make("script", { textContent: library }));
    const T = window.THREE, overlay = make("div", { className: "overlay" });
    const stage = make("div", { className: "stage", tabIndex: 0 }, overlay);
    stage.setAttribute("role", "group");
    stage.setAttribute("aria-label", "3-D view. Space plays, arrow keys step, plus and minus zoom, dragging turns.");
    const renderer = new T.WebGLRenderer({ antialias: true });
    renderer.setClearColor(0x101319);
    renderer.setPixelRatio(Math.min(2, devicePixelRatio));
    stage.prepend(renderer.domElement);
    const which = make("select", {}, ...takes.map((take, k) => make("option", { value: k, textContent: take.dataset.title })));
    const method = make("select"), play = make("button", { type: "button", textContent: "Play" });
    const slider = make("input", { type: "range", min: 0, value: 0, step: 1 });
    slider.setAttribute("aria-label", "Instant");
    box.replaceChildren(
      make("div", { className: "strip" }, make("label", {}, "Take ", which), make("label", {}, "Estimate of ", method)),
      stage, make("div", { className: "strip" }, play, slider));

    let take = null, shown = null, instant = 0, since = 0, due = false;
    const draw = () => {
      due = false;
      if (!take) return;
      const m = Number(method.value), cm = shown.show(instant, m), seconds = instant * take.span_s / (take.instants - 1 || 1);
      overlay.replaceChildren(
        `${take.simulated ? "simulated" : "recorded"}, ${seconds.toFixed(2)} of ${take.span_s.toFixed(1)} s`,
        coloured("truth", kTruth), coloured(`${take.methods[m]}, all joints: ${cm === cm ? `${cm.toFixed(1)} cm` : "no answer"}`,
          parseInt(take.colours[m].slice(1), 16)), coloured("from truth to estimate", kError));
      renderer.render(shown.scene, view.camera);
    };
    const redraw = () => {
      if (!due) requestAnimationFrame(draw);
      due = true;
    };
    const view = orbit(T, stage, redraw);
    const go = (i) => {
      instant = Math.min(take.instants - 1, Math.max(0, i));
      slider.value = instant;
      redraw();
    };
    const set = (playing) => {
      since = playing ? performance.now() : 0;
      play.textContent = playing ? "Pause" : "Play";
      if (playing && instant === take.instants - 1) go(0);
      if (playing) requestAnimationFrame(tick);
    };
    const tick = (now) => {
      if (!since) return;
      const steps = Math.floor((now - since) / 1000 * (take.instants - 1) / (take.span_s || 1));
      if (steps > 0) {
        since = now;
        go(instant + steps);
      }
      if (instant === take.instants - 1) set(false);
      else requestAnimationFrame(tick);
    };
    const load = async () => {
      set(false);
      take = await unpack(takes[which.value].textContent);
      shown = sceneOf(T, take);
      slider.max = take.instants - 1;
      method.replaceChildren(...take.methods.map((name, m) => make("option", { value: m, textContent: name })));
      method.value = Math.max(0, take.methods.indexOf("nonlinear"));
      view.aim(middleOf(take));
      go(0);
    };
    play.addEventListener("click", () => set(!since));
    slider.addEventListener("input", () => { set(false); go(Number(slider.value)); });
    method.addEventListener("change", redraw);
    which.addEventListener("change", load);
    const keys = { " ": () => set(!since), ArrowRight: () => go(instant + 1), ArrowLeft: () => go(instant - 1),
      "+": () => view.zoom(0.9), "-": () => view.zoom(1.1) };
    stage.addEventListener("keydown", (event) => {
      if (!keys[event.key]) return;
      event.preventDefault();
      keys[event.key]();
    });
    new ResizeObserver(() => {
      const { clientWidth: width, clientHeight: height } = stage;
      renderer.setSize(width, height, false);
      view.camera.aspect = width / Math.max(1, height);
      view.camera.updateProjectionMatrix();
      redraw();
    }).observe(stage);
    await load();
    box.dataset.ready = "true";
  };

  // Only when it comes into view: most readers of the tables never start it.
  new IntersectionObserver((entries, observer) => {
    if (!entries.some((entry) => entry.isIntersecting)) return;
    observer.disconnect();
    start().catch(({ message }) => box.replaceChildren(`The replay cannot be shown: ${message}`));
  }, { rootMargin: "200px" }).observe(box);
})();
