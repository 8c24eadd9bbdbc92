// Draws the recorded states again at every turn of the view, and values under the pointer.
// Without this script the pictures stand still; nothing is fetched with it.
(() => {
  "use strict";
  const store = document.getElementById("recorded");
  const names = store.dataset.names.split("\n");
  const bytesOf = (text) => Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const table = new Float64Array(bytesOf(store.textContent.trim()).buffer);
  const count = table.length / names.length;
  const column = (at) => table.subarray(at * count, (at + 1) * count);
  const times = column(0);
  const leaf = store.dataset.leaf ? store.dataset.leaf.split(" ").map(Number) : null;
  const axes = store.dataset.axes.split(" ").filter(Boolean).map(Number);
  const title = store.dataset.title;

  const ink = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  const shown = (value, digits = 10) => Number.isFinite(value) ? String(Number(value.toPrecision(digits))).replace("-", "−") : String(value);
  const made = (kind, fields = {}, ...children) => {
    const element = Object.assign(document.createElement(kind), fields);
    element.append(...children);
    return element;
  };

  // Two papers with the same pens: a canvas, and the text of an SVG file.
  class Screen {
    constructor(canvas) {
      const ratio = window.devicePixelRatio || 1;
      this.width = canvas.clientWidth;
      this.height = canvas.clientHeight;
      canvas.width = Math.round(ratio * this.width);
      canvas.height = Math.round(ratio * this.height);
      this.pen = canvas.getContext("2d");
      this.pen.scale(ratio, ratio);
      this.pen.lineJoin = this.pen.lineCap = "round";
    }
    path(points, colour, width) {
      this.pen.strokeStyle = colour;
      this.pen.lineWidth = width;
      this.pen.beginPath();
      points.forEach(([x, y], at) => (at ? this.pen.lineTo(x, y) : this.pen.moveTo(x, y)));
      this.pen.stroke();
    }
    disc([x, y], radius, colour) {
      this.pen.fillStyle = colour;
      this.pen.beginPath();
      this.pen.arc(x, y, radius, 0, 2 * Math.PI);
      this.pen.fill();
    }
    text(words, [x, y], anchor, colour, size = 12.5) {
      this.pen.font = `${size}px ${getComputedStyle(document.body).fontFamily}`;
      this.pen.textAlign = { start: "left", middle: "center", end: "right" }[anchor];
      this.pen.textBaseline = "middle";
      this.pen.strokeStyle = ink("--card");
      this.pen.lineWidth = 3.5;
      this.pen.strokeText(words, x, y);
      this.pen.fillStyle = colour;
      this.pen.fillText(words, x, y);
    }
    clip([left, top, right, bottom], draw) {
      this.pen.save();
      this.pen.beginPath();
      this.pen.rect(left, top, right - left, bottom - top);
      this.pen.clip();
      draw();
      this.pen.restore();
    }
  }
  class Drawing {
    constructor(canvas) {
      this.width = canvas.clientWidth;
      this.height = canvas.clientHeight;
      this.parts = [`<rect width="100%" height="100%" fill="${ink("--card")}"/>`];
    }
    path(points, colour, width) {
      const line = points.map(([x, y]) => `${x.toFixed(2)},${y.toFixed(2)}`).join(" ");
      this.parts.push(`<polyline points="${line}" fill="none" stroke="${colour}" stroke-width="${width}" stroke-linejoin="round" stroke-linecap="round"/>`);
    }
    disc([x, y], radius, colour) {
      this.parts.push(`<circle cx="${x.toFixed(2)}" cy="${y.toFixed(2)}" r="${radius}" fill="${colour}"/>`);
    }
    text(words, [x, y], anchor, colour, size = 12.5) {
      const safe = words.replace(/[&<>]/g, (letter) => `&#${letter.charCodeAt(0)};`);
      this.parts.push(`<text x="${x.toFixed(2)}" y="${y.toFixed(2)}" text-anchor="${anchor}" dominant-baseline="central" fill="${colour}" font-size="${size}">${safe}</text>`);
    }
    clip([left, top, right, bottom], draw) {
      const id = `clip${this.parts.length}`;
      this.parts.push(`<clipPath id="${id}"><rect x="${left}" y="${top}" width="${right - left}" height="${bottom - top}"/></clipPath><g clip-path="url&#40;#${id}&#41;">`);
      draw();
      this.parts.push("</g>");
    }
    finish() {
      const size = `width="${this.width}" height="${this.height}" viewBox="0 0 ${this.width} ${this.height}"`;
      return `<svg xmlns="http://www.w3.org/2000/svg" ${size} font-family="sans-serif">${this.parts.join("")}</svg>`;
    }
  }

  const save = (content, type, name) => {
    const link = made("a", { download: name });
    link.href = URL.createObjectURL(new Blob([content], { type }));
    document.body.append(link);
    link.click();
    link.remove();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  };
  const fileName = (words) => `${title} ${words}`.toLowerCase().replace(/[^a-z0-9]+/g, "-").replace(/^-|-$/g, "");
  const button = (words, hint, action) => {
    const element = made("button", { type: "button", textContent: words, title: hint });
    element.addEventListener("click", action);
    return element;
  };
  const choice = (hint, options, chosen, changed) => {
    const select = made("select", { title: hint });
    select.setAttribute("aria-label", hint);
    options.forEach(([value, words]) => select.append(made("option", { value, textContent: words, selected: value === chosen })));
    select.addEventListener("change", () => changed(Number(select.value)));
    return select;
  };

  const HINT = "Point at a curve for the values there.";

  // A figure whose picture is a canvas with controls above and the values under the pointer below.
  class Figure {
    constructor(figure, shape, hint) {
      this.figure = figure;
      this.canvas = made("canvas", { tabIndex: 0, className: shape });
      this.canvas.setAttribute("role", "img");
      this.canvas.setAttribute("aria-label", hint);
      this.controls = made("div", { className: "controls" });
      this.values = made("output", { className: "values", textContent: HINT });
      const svg = figure.querySelector("svg");
      if (svg) svg.replaceWith(this.canvas);
      else figure.querySelector("h3").after(this.canvas);
      this.canvas.before(this.controls);
      this.canvas.after(this.values);
      this.asked = false;
      new ResizeObserver(() => this.draw()).observe(this.canvas);
      matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.draw());
      this.canvas.addEventListener("pointerdown", (event) => this.press(event));
      this.canvas.addEventListener("pointermove", (event) => this.point(event));
      this.canvas.addEventListener("pointerleave", () => mark(-1));
      this.canvas.addEventListener("dblclick", () => this.reset());
      this.canvas.addEventListener("keydown", (event) => this.key(event));
      this.canvas.addEventListener("wheel", (event) => {
        // A page that is scrolled past goes on scrolling.
        if (document.activeElement !== this.canvas && !event.ctrlKey) return;
        event.preventDefault();
        this.zoom(Math.exp(-0.0015 * event.deltaY), this.place(event));
      }, { passive: false });
    }
    buttons(words) {
      this.controls.append(
        made("span", { className: "gap" }),
        button("+", "nearer (key +)", () => this.zoom(1.25)),
        button("−", "farther (key −)", () => this.zoom(0.8)),
        button("Reset", "the first view (double click)", () => this.reset()),
      );
      const heading = this.figure.querySelector("h3");
      this.heading = heading.firstChild;
      heading.append(made("span", { className: "saves" },
        button("SVG", "save as SVG", () => save(this.svg(), "image/svg+xml", `${fileName(words())}.svg`)),
        button("PNG", "save as PNG", () => {
          this.render(new Screen(this.canvas), false);
          save(bytesOf(this.canvas.toDataURL("image/png").split(",")[1]), "image/png", `${fileName(words())}.png`);
          this.draw();
        }),
      ));
    }
    place(event) {
      const { left, top } = this.canvas.getBoundingClientRect();
      return [event.clientX - left, event.clientY - top];
    }
    press(event) {
      this.canvas.focus({ preventScroll: true });
      this.canvas.setPointerCapture(event.pointerId);
      this.last = this.place(event);
    }
    point(event) {
      const at = this.place(event);
      if (event.buttons && this.last) {
        this.drag(at[0] - this.last[0], at[1] - this.last[1], event);
        this.last = at;
      } else {
        mark(this.nearest(at));
      }
    }
    key(event) {
      const turn = { ArrowLeft: [-12, 0], ArrowRight: [12, 0], ArrowUp: [0, -12], ArrowDown: [0, 12] }[event.key];
      if (turn) this.drag(...turn, event);
      else if (event.key === "+" || event.key === "=") this.zoom(1.25);
      else if (event.key === "-") this.zoom(0.8);
      else if (event.key === "0" || event.key === "Home") this.reset();
      else return;
      event.preventDefault();
    }
    svg() {
      const drawing = new Drawing(this.canvas);
      this.render(drawing, false);
      return drawing.finish();
    }
    draw() {
      if (this.asked) return;
      this.asked = true;
      requestAnimationFrame(() => {
        this.asked = false;
        if (this.canvas.clientWidth) this.render(new Screen(this.canvas), true);
      });
    }
  }

  const ranges = (values) => {
    let [low, high] = [Infinity, -Infinity];
    for (const value of values) {
      if (Number.isFinite(value)) {
        low = Math.min(low, value);
        high = Math.max(high, value);
      }
    }
    return low <= high ? [low, high] : [0, 1];
  };
  const ticks = (low, high, most) => {
    const rough = (high - low) / most;
    const power = 10 ** Math.floor(Math.log10(rough));
    const step = power * [1, 2, 5, 10].find((factor) => factor * power >= rough);
    const found = [];
    for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k += 1) found.push(k * step);
    return found;
  };

  // An orbit in three columns, or two of them in a plane, as seen from an azimuth and an elevation.
  class Orbit extends Figure {
    constructor(figure) {
      super(figure, "square", "The orbit: drag or arrow keys turn it, plus and minus zoom, shift moves it");
      this.axes = [...axes, -1].slice(0, 3);
      const options = names.map((name, at) => [at, name]).slice(1).concat([[0, names[0]]]);
      this.selects = [0, 1, 2].map((axis) => choice(
        `axis ${axis + 1}`, axis === 2 ? [[-1, "plane"], ...options] : options, this.axes[axis],
        (chosen) => { this.axes[axis] = chosen; this.fit(); this.draw(); },
      ));
      this.controls.append(...this.selects);
      this.buttons(() => this.axes.filter((at) => at >= 0).map((at) => names[at]).join(" "));
      this.reset();
    }
    reset() {
      [this.azimuth, this.elevation, this.scale, this.shift] = [0.6, 0.42, 1, [0, 0]];
      this.fit();
      this.draw();
    }
    fit() {
      this.flat = this.axes[2] < 0;
      this.heading.textContent = `${this.flat ? "Plane" : "Orbit in"} (${this.axes.filter((at) => at >= 0).map((at) => names[at]).join(", ")})`;
      this.onLeaf = leaf && this.axes.every((at, axis) => at === axes[axis]);
      this.boxes = this.axes.map((at, axis) => {
        if (this.onLeaf) return [leaf[axis], Math.max(...leaf.slice(3))];
        if (at < 0) return [0, 1];
        const [low, high] = ranges(column(at));
        const half = (high - low) / 2;
        const middle = low + half;
        return [middle, half > 8 * Number.EPSILON * Math.abs(middle) ? half : Math.abs(middle) || 1];
      });
      this.places = [0, 1, 2].map((axis) => {
        const [middle, half] = this.boxes[axis];
        return this.axes[axis] < 0 ? new Float64Array(count) : column(this.axes[axis]).map((value) => (value - middle) / half);
      });
    }
    drag(dx, dy, event) {
      if (this.flat || event.shiftKey) {
        this.shift = [this.shift[0] + dx, this.shift[1] + dy];
      } else {
        this.azimuth -= 0.01 * dx;
        this.elevation = Math.max(-Math.PI / 2, Math.min(Math.PI / 2, this.elevation + 0.01 * dy));
      }
      this.draw();
    }
    zoom(factor, at) {
      const next = Math.max(0.2, Math.min(1e6, this.scale * factor));
      const middle = this.middle();
      const about = at || [middle[0] + this.shift[0], middle[1] + this.shift[1]];
      const by = next / this.scale;
      this.shift = this.shift.map((shift, axis) => (shift + middle[axis] - about[axis]) * by + about[axis] - middle[axis]);
      this.scale = next;
      this.draw();
    }
    middle() {
      const { clientWidth: width, clientHeight: height } = this.canvas;
      return this.flat ? [width / 2 + 22, height / 2 - 16] : [width / 2, height / 2 - (this.onLeaf ? 0 : 4)];
    }
    view() {
      const [middle, size] = [this.middle(), this.canvas.clientWidth];
      const unit = size * this.scale * (this.flat ? 0.41 : this.onLeaf ? 0.408 : 0.272);
      const [x0, y0] = [middle[0] + this.shift[0], middle[1] + this.shift[1]];
      if (this.flat) return (x, y) => [x0 + unit * x, y0 - unit * y, 0];
      const [sa, ca] = [Math.sin(this.azimuth), Math.cos(this.azimuth)];
      const [se, ce] = [Math.sin(this.elevation), Math.cos(this.elevation)];
      return (x, y, z) => {
        const along = ca * x + sa * y;
        return [x0 + unit * (ca * y - sa * x), y0 - unit * (ce * z - se * along), se * z + ce * along];
      };
    }
    projected() {
      const project = this.view();
      const [x, y, z] = this.places;
      return Array.from({ length: count }, (_, k) => project(x[k], y[k], z[k]));
    }
    nearest([x, y]) {
      let [found, least] = [-1, 900];
      this.projected().forEach(([px, py, near], k) => {
        // Of points that lie over each other the one in front.
        const distance = (px - x) ** 2 + (py - y) ** 2 - near;
        if (distance < least) [found, least] = [k, distance];
      });
      return found;
    }
    render(paper, isMarked) {
      paper.pen?.clearRect(0, 0, paper.width, paper.height);
      const project = this.view();
      const points = this.projected();
      const line = (from, to, colour) => paper.path([project(...from), project(...to)], colour, 1);
      if (this.flat) this.frame(paper);
      else if (this.onLeaf) this.drawLeaf(paper, project);
      else this.drawBox(paper, project, line);
      const drawn = () => {
        if (!this.flat && !this.onLeaf) {
          const floor = this.elevation >= 0 ? -1 : 1;
          this.orbit(paper, Array.from(points, (_, k) => project(this.places[0][k], this.places[1][k], floor)), () => 0, ["--shadow"], 1);
        }
        const side = this.onLeaf ? (k) => Number(this.isNear(k)) : () => 1;
        this.orbit(paper, points, side, ["--far", "--s0"], 1.5);
        const ends = points.filter(([x, y]) => Number.isFinite(x + y));
        if (ends.length) {
          const last = ends[ends.length - 1];
          paper.disc(last, 5.5, ink("--s1"));
          paper.disc(last, 3.5, ink("--card"));
          paper.disc(ends[0], 5, ink("--s1"));
        }
        if (isMarked && marked >= 0 && Number.isFinite(points[marked][0])) {
          paper.disc(points[marked], 6, ink("--card"));
          paper.disc(points[marked], 4, ink("--ink"));
        }
      };
      if (this.flat) paper.clip(this.edges(), drawn);
      else drawn();
    }
    // Lines between neighbours, or dots where these lie far apart; far sides first.
    orbit(paper, points, side, colours, width) {
      let short = 0;
      for (let k = 1; k < points.length; k += 1) {
        if (Math.hypot(points[k][0] - points[k - 1][0], points[k][1] - points[k - 1][1]) < 40 * Math.max(1, this.scale)) short += 1;
      }
      const isLine = 2 * short >= points.length - 1;
      for (let level = 0; level < colours.length; level += 1) {
        const colour = ink(colours[level]);
        let run = [];
        const flush = () => { if (run.length > 1) paper.path(run, colour, level || colours.length === 1 ? width : 1); run = []; };
        for (let k = 0; k < points.length; k += 1) {
          const finite = Number.isFinite(points[k][0] + points[k][1]);
          if (!isLine) {
            if (finite && side(k) === level) paper.disc(points[k], width, colour);
          } else if (!finite) {
            flush();
          } else if (side(k) === level) {
            run.push(points[k]);
          } else {
            if (run.length) run.push(points[k]);
            flush();
          }
        }
        flush();
      }
    }
    eye() {
      const ce = Math.cos(this.elevation);
      return [ce * Math.cos(this.azimuth), ce * Math.sin(this.azimuth), Math.sin(this.elevation)];
    }
    // Whether the leaf's outward normal at a place of the box faces the eye.
    faces(place) {
      const eye = this.eye();
      const reach = Math.max(...leaf.slice(3));
      return place.reduce((sum, x, axis) => sum + x * eye[axis] / (leaf[3 + axis] / reach) ** 2, 0) >= 0;
    }
    isNear(k) {
      return this.faces(this.places.map((place) => place[k]));
    }
    drawLeaf(paper, project) {
      const reach = Math.max(...leaf.slice(3));
      const axes = leaf.slice(3).map((axis) => axis / reach);
      const at = (latitude, longitude) => [
        axes[0] * Math.cos(latitude) * Math.cos(longitude),
        axes[1] * Math.cos(latitude) * Math.sin(longitude),
        axes[2] * Math.sin(latitude),
      ];
      const curves = [];
      for (let k = 0; k < 12; k += 1) curves.push(Array.from({ length: 49 }, (_, j) => at(Math.PI * (j / 48 - 0.5), Math.PI * k / 6)));
      for (let k = 1; k < 6; k += 1) curves.push(Array.from({ length: 97 }, (_, j) => at(Math.PI * (k / 6 - 0.5), Math.PI * j / 48)));
      for (const isFront of [false, true]) {
        const colour = ink(isFront ? "--shadow" : "--line");
        for (const curve of curves) {
          let run = [];
          for (const place of curve) {
            if (this.faces(place) === isFront) run.push(project(...place));
            else { if (run.length > 1) paper.path(run, colour, 1); run = []; }
          }
          if (run.length > 1) paper.path(run, colour, 1);
        }
      }
      // The rim: where the normal is at right angles to the eye.
      const eye = this.eye().map((value, axis) => value / axes[axis]);
      const long = Math.hypot(...eye);
      const normal = eye.map((value) => value / long);
      const other = Math.abs(normal[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0];
      const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
      const u = cross(normal, other);
      const size = Math.hypot(...u);
      const [first, second] = [u.map((value) => value / size), cross(normal, u.map((value) => value / size))];
      paper.path(Array.from({ length: 97 }, (_, k) => {
        const [c, s] = [Math.cos(Math.PI * k / 48), Math.sin(Math.PI * k / 48)];
        return project(...axes.map((axis, i) => axis * (c * first[i] + s * second[i])));
      }), ink("--axis"), 1);
      for (let axis = 0; axis < 3; axis += 1) {
        const along = (length) => [0, 1, 2].map((i) => (i === axis ? length : 0));
        paper.path([project(...along(axes[axis])), project(...along(axes[axis] + 0.16))], ink("--axis"), 1);
        paper.text(names[this.axes[axis]], project(...along(axes[axis] + 0.23)), "middle", ink("--ink"), 14);
      }
    }
    drawBox(paper, project, line) {
      const near = this.eye().map((value) => (value < 0 ? -1 : 1));
      const grid = ink("--line");
      for (const a of [-1, 1]) {
        for (const b of [-1, 1]) {
          if (a !== near[1] || b !== near[2]) line([-1, a, b], [1, a, b], grid);
          if (a !== near[0] || b !== near[2]) line([a, -1, b], [a, 1, b], grid);
          if (a !== near[0] || b !== near[1]) line([a, b, -1], [a, b, 1], grid);
        }
      }
      const [x, y, z] = near;
      // Of the two upright edges at the sides the left one.
      const left = project(x, -y, 0)[0] < project(-x, y, 0)[0] ? [x, -y] : [-x, y];
      const edges = [
        [[-1, y, -z], [1, y, -z]],
        [[x, -1, -z], [x, 1, -z]],
        [[...left, -1], [...left, 1]],
      ];
      const centre = project(0, 0, 0);
      edges.forEach(([from, to], axis) => {
        line(from, to, ink("--axis"));
        const [a, b] = [project(...from), project(...to)];
        // Labels stand off the edge, on the side away from the box.
        let [nx, ny] = [b[1] - a[1], a[0] - b[0]];
        const length = Math.hypot(nx, ny);
        if (length < 24) return;
        const outward = nx * ((a[0] + b[0]) / 2 - centre[0]) + ny * ((a[1] + b[1]) / 2 - centre[1]) < 0 ? -1 : 1;
        [nx, ny] = [outward * nx / length, outward * ny / length];
        const anchor = nx > 0.4 ? "start" : nx < -0.4 ? "end" : "middle";
        const at = (part, off) => [a[0] + part * (b[0] - a[0]) + off * nx, a[1] + part * (b[1] - a[1]) + off * ny];
        const [middle, half] = this.boxes[axis];
        paper.text(shown(middle - half, 3), at(0.06, 12), anchor, ink("--soft"));
        paper.text(names[this.axes[axis]], at(0.5, 14), anchor, ink("--ink"), 14);
        paper.text(shown(middle + half, 3), at(0.94, 12), anchor, ink("--soft"));
      });
    }
    edges() {
      const { clientWidth: width, clientHeight: height } = this.canvas;
      return [64, 14, width - 14, height - 48];
    }
    frame(paper) {
      const [left, top, right, bottom] = this.edges();
      const [middle, unit] = [this.middle(), this.canvas.clientWidth * this.scale * 0.41];
      const low = [left, bottom].map((edge, axis) => {
        const place = (axis ? -1 : 1) * (edge - middle[axis] - this.shift[axis]) / unit;
        return this.boxes[axis][0] + place * this.boxes[axis][1];
      });
      const high = [right, top].map((edge, axis) => {
        const place = (axis ? -1 : 1) * (edge - middle[axis] - this.shift[axis]) / unit;
        return this.boxes[axis][0] + place * this.boxes[axis][1];
      });
      axesOf(paper, [left, top, right, bottom], low, high, [names[this.axes[0]], names[this.axes[1]]], 6);
    }
  }

  // Where a label stands so that no part of it leaves the paper.
  const measuring = made("canvas").getContext("2d");
  const within = (paper, words, x, anchor) => {
    measuring.font = `12.5px ${getComputedStyle(document.body).fontFamily}`;
    const width = measuring.measureText(words).width + 2;
    const before = { middle: width / 2, end: width }[anchor];
    return Math.max(before, Math.min(x, paper.width - (width - before)));
  };

  // A frame with lines at round numbers.
  const axesOf = (paper, [left, top, right, bottom], low, high, labels, most) => {
    const [grid, soft, dark] = [ink("--line"), ink("--soft"), ink("--ink")];
    for (const value of ticks(low[0], high[0], most)) {
      const x = left + (value - low[0]) / (high[0] - low[0]) * (right - left);
      paper.path([[x, top], [x, bottom]], grid, 1);
      const words = shown(value, 6);
      paper.text(words, [within(paper, words, x, "middle"), bottom + 13], "middle", soft);
    }
    for (const value of ticks(low[1], high[1], 5)) {
      const y = bottom - (value - low[1]) / (high[1] - low[1]) * (bottom - top);
      paper.path([[left, y], [right, y]], grid, 1);
      const words = shown(value, 6);
      paper.text(words, [within(paper, words, left - 8, "end"), y], "end", soft);
    }
    paper.path([[left, top], [right, top], [right, bottom], [left, bottom], [left, top]], ink("--axis"), 1);
    paper.text(labels[0], [(left + right) / 2, bottom + 33], "middle", dark);
    paper.text(labels[1], [left, top - 12], "start", dark);
  };

  // One column against time.
  class History extends Figure {
    constructor(figure) {
      super(figure, "wide", "A quantity over time: drag moves it, plus and minus zoom");
      this.chosen = 1;
      this.controls.append(
        choice("quantity", names.map((name, at) => [at, name]).slice(1), 1, (chosen) => { this.chosen = chosen; this.fit(); this.draw(); }),
        made("label", {}, (this.change = made("input", { type: "checkbox" })), " change since the start"),
      );
      this.change.addEventListener("change", () => { this.fit(true); this.draw(); });
      this.buttons(() => `${names[this.chosen]} over time`);
      this.reset();
    }
    reset() {
      this.span = ranges(times);
      if (this.span[0] === this.span[1]) this.span = [this.span[0], this.span[0] + 1];
      this.whole = this.span;
      this.fit();
      this.draw();
    }
    fit(isChosen) {
      const values = column(this.chosen);
      const start = values[0];
      const [low, high] = ranges(values);
      // What hardly varies is seen in its change alone.
      if (!isChosen) this.change.checked = Number.isFinite(start) && Math.max(high - start, start - low) < 1e-2 * Math.abs(start);
      this.series = this.change.checked ? values.map((value) => value - start) : values;
    }
    label() {
      const name = names[this.chosen];
      return this.change.checked ? `${name}(t) − ${name}(0)` : name;
    }
    edges() {
      const { clientWidth: width, clientHeight: height } = this.canvas;
      return [84, 26, width - 16, height - 46];
    }
    drag(dx) {
      const [left, , right] = this.edges();
      const by = -dx / (right - left) * (this.span[1] - this.span[0]);
      this.span = this.span.map((time) => time + by);
      this.draw();
    }
    zoom(factor, at) {
      const [left, , right] = this.edges();
      const [low, high] = this.span;
      const about = low + (at ? (at[0] - left) / (right - left) : 0.5) * (high - low);
      if ((high - low) / factor < 1e-12 * Math.max(Math.abs(low), Math.abs(high))) return;
      this.span = this.span.map((time) => about + (time - about) / factor);
      if (this.span[0] <= this.whole[0] && this.span[1] >= this.whole[1]) this.span = this.whole;
      this.draw();
    }
    nearest([x]) {
      const [left, , right] = this.edges();
      const time = this.span[0] + (x - left) / (right - left) * (this.span[1] - this.span[0]);
      let found = -1;
      times.forEach((own, k) => {
        if (found < 0 || Math.abs(own - time) < Math.abs(times[found] - time)) found = k;
      });
      return found;
    }
    render(paper, isMarked) {
      paper.pen?.clearRect(0, 0, paper.width, paper.height);
      const edges = this.edges();
      const [left, top, right, bottom] = edges;
      const [from, to] = this.span;
      const inside = [];
      times.forEach((time, k) => { if (time >= from && time <= to) inside.push(k); });
      let [low, high] = ranges(inside.map((k) => this.series[k]));
      const margin = 0.06 * (high - low) || 0.5 * Math.abs(high) || 1;
      [low, high] = [low - margin, high + margin];
      axesOf(paper, edges, [from, low], [to, high], [`time ${names[0]}`, this.label()], 8);
      const at = (k) => [left + (times[k] - from) / (to - from) * (right - left), bottom - (this.series[k] - low) / (high - low) * (bottom - top)];
      const colour = ink("--s0");
      paper.clip(edges, () => {
        let run = [];
        // Of few samples each is a dot: nothing is known between them.
        const isSparse = inside.length <= (right - left) / 16;
        const flush = () => {
          if (run.length > 1) paper.path(run, isSparse ? ink("--far") : colour, isSparse ? 1 : 1.5);
          if (isSparse || run.length === 1) run.forEach((place) => paper.disc(place, isSparse ? 2.6 : 1.5, colour));
          run = [];
        };
        const begin = Math.max(0, (inside[0] ?? 0) - 1);
        const end = Math.min(count - 1, (inside[inside.length - 1] ?? -1) + 1);
        for (let k = begin; k <= end; k += 1) {
          if (Number.isFinite(this.series[k])) run.push(at(k));
          else flush();
        }
        flush();
        if (isMarked && marked >= 0 && Number.isFinite(this.series[marked])) {
          const place = at(marked);
          paper.path([[place[0], top], [place[0], bottom]], ink("--axis"), 1);
          paper.disc(place, 6, ink("--card"));
          paper.disc(place, 4, ink("--ink"));
        }
      });
    }
  }

  // The sample under the pointer, marked in every picture.
  let marked = -1;
  const figures = [];
  const mark = (k) => {
    if (k === marked) return;
    marked = k;
    const most = 12;
    const said = k < 0 ? HINT : names.slice(0, most + 1).map((name, at) => `${name} = ${shown(column(at)[k])}`).join("   ") + (names.length > most + 1 ? " …" : "");
    figures.forEach((figure) => {
      figure.values.textContent = said;
      figure.draw();
    });
  };

  const orbit = document.querySelector("svg.orbit")?.closest("figure");
  if (orbit && axes.length > 1) figures.push(new Orbit(orbit));
  const history = document.querySelector("figure.history");
  if (history) {
    history.hidden = false;
    figures.push(new History(history));
  }
  figures.forEach((figure) => figure.draw());

  // The pictures that stand still can be saved too.
  document.querySelectorAll("figure > svg").forEach((svg) => {
    const heading = svg.closest("figure").querySelector("h3");
    const words = heading.textContent;
    heading.append(button("SVG", "save as SVG", () => save(new XMLSerializer().serializeToString(svg), "image/svg+xml", `${fileName(words)}.svg`)));
  });
})();
