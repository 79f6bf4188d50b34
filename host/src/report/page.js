"use strict";
(() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const $ = id => document.getElementById(id);

  /** An element with attributes and children. */
  const make = (name, attributes = {}, ...children) => {
    const element = document.createElement(name);
    for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
    element.append(...children);
    return element;
  };
  const draw = (parent, name, attributes, text = "") => {
    const element = document.createElementNS("http://www.w3.org/2000/svg", name);
    for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
    element.textContent = text;
    return parent.appendChild(element);
  };
  const show = value => {
    if (value === null || value === undefined) return "–";
    if (typeof value !== "number" || Number.isInteger(value)) return String(value);
    const size = Math.abs(value);
    return size >= 1e6 || size < 1e-3 ? value.toExponential(3) : String(Number(value.toPrecision(6)));
  };
  /** A value of a column; places on the sky have more digits than the rest. */
  const cell = (column, value) =>
    value !== null && column.digits > 9 ? value.toFixed(6) : show(value);
  const pairs = (list, entries) => entries.forEach(([name, value]) =>
    list.append(make("dt", {}, name), make("dd", {}, value)));

  // Head
  document.title = `${data.title} · Skyfront`;
  $("title").textContent = data.title;
  data.facts.forEach(({ name, value, alert }) => $("facts").append(
    make("div", alert ? { class: "alert" } : {}, make("dt", {}, name), make("dd", {}, show(value)))));
  pairs($("parameters"), data.parameters);
  pairs($("provenance"), data.provenance);

  // The view: a window onto the image, in image pixels from its upper left corner.
  const sky = $("sky"), { width, height } = data;
  const view = { x: 0, y: 0, w: width, h: height };
  const apply = () => sky.setAttribute("viewBox", `${view.x} ${view.y} ${view.w} ${view.h}`);
  const fit = () => { Object.assign(view, { x: 0, y: 0, w: width, h: height }); apply(); };
  const place = event => {
    const point = new DOMPoint(event.clientX, event.clientY);
    return point.matrixTransform(sky.getScreenCTM().inverse());
  };
  /** Zooms about a point that stays where it is. */
  const zoom = (factor, at = { x: view.x + view.w / 2, y: view.y + view.h / 2 }) => {
    const least = 8 / Math.max(width, height);
    const scale = Math.min(2, Math.max(least, view.w * factor / width)) * width / view.w;
    view.x = at.x - (at.x - view.x) * scale;
    view.y = at.y - (at.y - view.y) * scale;
    view.w *= scale;
    view.h *= scale;
    apply();
  };
  const move = (dx, dy) => { view.x += dx; view.y += dy; apply(); };
  const visit = path => {
    const box = path.getBBox(), s = 0.01; // outlines are in hundredths of a pixel
    const size = Math.min(Math.max(6 * Math.max(box.width, box.height) * s, 40), Math.max(width, height));
    view.w = size * Math.max(1, width / height);
    view.h = view.w * height / width;
    view.x = (box.x + box.width / 2) * s - view.w / 2;
    view.y = (box.y + box.height / 2) * s - view.h / 2;
    apply();
  };
  const picture = $("picture");
  for (const [key, value] of Object.entries({ href: data.preview, width, height, preserveAspectRatio: "none" }))
    picture.setAttribute(key, value);
  fit();

  // Outlines and rows: source i has paths[i] and rows[i].
  $("paths").setAttribute("transform", "scale(0.01)");
  const paths = data.outlines.map(outline =>
    draw($("paths"), "path", { d: outline, "fill-rule": "evenodd" }));
  const label = i => data.rows[i][0];
  const rows = data.rows.map((values, i) => {
    const row = make("tr", { tabindex: i === 0 ? "0" : "-1", "data-source": i });
    row.append(...values.map((value, at) => make("td", {}, cell(data.columns[at], value))));
    return row;
  });
  paths.forEach((path, i) => { path.dataset.source = i; });
  const body = $("rows");
  body.append(...rows);
  $("count").textContent = `${data.rows.length} source${data.rows.length === 1 ? "" : "s"}`;
  if (!rows.length)
    body.append(make("tr", {}, make("td", { class: "empty", colspan: data.columns.length }, "No sources were found.")));

  const mark = (name, i, on) => [paths[i], rows[i]].forEach(element => element?.classList.toggle(name, on));
  let hovered = null, chosen = null;
  const hover = i => {
    if (hovered !== null) mark("hover", hovered, false);
    hovered = i;
    if (i !== null) { mark("hover", i, true); paths[i]?.parentNode.append(paths[i]); }
  };
  const choose = i => {
    if (chosen !== null) mark("chosen", chosen, false);
    chosen = i;
    if (i !== null) mark("chosen", i, true);
  };
  const source = event => {
    const owner = event.target.closest?.("[data-source]");
    return owner ? Number(owner.dataset.source) : null;
  };

  // A card with the source's row beside the pointer.
  const card = $("card");
  const tell = (i, event) => {
    card.hidden = i === null;
    if (i === null) return;
    const list = make("dl");
    pairs(list, data.columns.map((column, at) => [column.name, `${cell(column, data.rows[i][at])} ${column.unit}`]).slice(0, 14));
    card.replaceChildren(list);
    const frame = card.parentElement.getBoundingClientRect();
    const [x, y] = [event.clientX - frame.left, event.clientY - frame.top];
    card.style.left = `${x + 18 + card.offsetWidth > frame.width ? x - 18 - card.offsetWidth : x + 18}px`;
    card.style.top = `${Math.max(52, Math.min(y + 12, frame.height - card.offsetHeight - 6))}px`;
  };

  // Pointer on the image
  const held = new Map();
  let moved = 0;
  sky.addEventListener("wheel", event => {
    event.preventDefault();
    zoom(Math.exp(Math.sign(event.deltaY) * 0.18), place(event));
  }, { passive: false });
  sky.addEventListener("pointerdown", event => { held.set(event.pointerId, place(event)); moved = 0; });
  addEventListener("pointerup", event => { held.delete(event.pointerId); sky.classList.remove("moving"); });
  addEventListener("pointercancel", event => held.delete(event.pointerId));
  sky.addEventListener("pointermove", event => {
    const at = place(event);
    const inside = at.x >= 0 && at.y >= 0 && at.x < width && at.y < height;
    // FITS: the centre of the lower left pixel is (1, 1).
    $("pointer").textContent = inside ? `x ${(at.x + 0.5).toFixed(1)}  y ${(height - at.y + 0.5).toFixed(1)}` : "";
    const before = held.get(event.pointerId);
    if (held.size === 1 && before) {
      moved += Math.hypot(event.movementX, event.movementY);
      if (moved > 3) { sky.classList.add("moving"); move(before.x - at.x, before.y - at.y); tell(null); }
    } else if (held.size === 2 && before) {
      const other = [...held].find(([id]) => id !== event.pointerId)[1];
      const length = point => Math.hypot(point.x - other.x, point.y - other.y);
      zoom(length(before) / Math.max(length(at), 1e-6), other);
      held.set(event.pointerId, place(event));
    } else {
      tell(source(event), event);
    }
  });
  sky.addEventListener("pointerover", event => hover(source(event)));
  sky.addEventListener("pointerleave", () => { hover(null); tell(null); });
  sky.addEventListener("click", event => {
    if (moved > 3) return;
    const i = source(event);
    choose(i);
    if (i !== null) rows[i].scrollIntoView({ block: "center" });
  });

  // Rows
  const open = i => { choose(i); if (paths[i]?.getAttribute("d")) visit(paths[i]); };
  body.addEventListener("pointerover", event => hover(source(event)));
  body.addEventListener("pointerleave", () => hover(null));
  body.addEventListener("focusin", event => hover(source(event)));
  body.addEventListener("focusout", () => hover(null));
  body.addEventListener("click", event => { if (source(event) !== null) open(source(event)); });
  body.addEventListener("keydown", event => {
    const row = event.target.closest("tr");
    const to = { ArrowDown: row?.nextElementSibling, ArrowUp: row?.previousElementSibling,
      Home: body.firstElementChild, End: body.lastElementChild }[event.key];
    if (to) {
      row.tabIndex = -1;
      to.tabIndex = 0;
      to.focus();
    } else if ((event.key === "Enter" || event.key === " ") && source(event) !== null) {
      open(source(event));
    } else {
      return;
    }
    event.preventDefault();
  });

  // Columns sort by a click: up, then down. Missing values come last.
  const heads = data.columns.map((column, at) => {
    const button = make("button", { title: column.description },
      make("b", {}, column.name), make("small", {}, column.unit));
    const head = make("th", { scope: "col", "aria-sort": at === 0 ? "ascending" : "none" }, button);
    button.addEventListener("click", () => {
      const down = head.getAttribute("aria-sort") === "ascending";
      heads.forEach(other => other.setAttribute("aria-sort", "none"));
      head.setAttribute("aria-sort", down ? "descending" : "ascending");
      const value = row => data.rows[row.dataset.source][at];
      const order = [...rows].sort((a, b) => {
        const [x, y] = [value(a), value(b)];
        if (x === null || y === null) return (x === null) - (y === null);
        return down ? y - x : x - y;
      });
      body.append(...order);
      order.forEach((row, index) => { row.tabIndex = index === 0 ? 0 : -1; });
    });
    return head;
  });
  $("head").append(make("tr", {}, ...heads));

  // Toolbar and keys
  const flip = (button, name, pressed) => {
    const on = button.getAttribute("aria-pressed") !== "true";
    button.setAttribute("aria-pressed", on);
    sky.classList.toggle(name, on === pressed);
  };
  const actions = {
    fit: () => fit(), in: () => zoom(1 / 1.5), out: () => zoom(1.5),
    outlines: () => flip($("outlines"), "bare", false), invert: () => flip($("invert"), "inverted", true),
  };
  Object.entries(actions).forEach(([id, action]) => $(id).addEventListener("click", action));
  sky.addEventListener("keydown", event => {
    const step = view.w / 10;
    const keys = { "0": actions.fit, "+": actions.in, "=": actions.in, "-": actions.out, o: actions.outlines, i: actions.invert,
      ArrowLeft: () => move(-step, 0), ArrowRight: () => move(step, 0),
      ArrowUp: () => move(0, -step), ArrowDown: () => move(0, step) };
    if (keys[event.key] && !event.ctrlKey && !event.metaKey) { keys[event.key](); event.preventDefault(); }
  });

  // Stages
  data.stages.forEach(({ name, note, image }) => {
    const button = make("button", { "aria-label": `Enlarge: ${name}` },
      make("img", { src: image, alt: `${name}: ${note}` }), make("span", {}, name), make("small", {}, note));
    button.addEventListener("click", () => {
      Object.assign($("large-image"), { src: image, alt: name });
      $("large-name").textContent = `${name}: ${note}`;
      $("large").showModal();
    });
    $("stages").append(button);
  });
  $("large").addEventListener("click", () => $("large").close());

  // Charts: a frame in which x runs along [from, to] and y along powers of ten.
  const chart = (svg, from, to, low, high, xName, yName) => {
    const [left, top, w, h] = [62, 12, 484, 200];
    const X = x => left + (x - from) / (to - from) * w;
    const Y = y => top + h - (Math.log10(y) - low) / Math.max(high - low, 1) * h;
    const every = Math.ceil((high - low) / 6) || 1;
    for (let power = low; power <= high; power += every) {
      draw(svg, "line", { x1: left, x2: left + w, y1: Y(10 ** power), y2: Y(10 ** power), class: "grid" });
      const text = power >= 0 && power < 4 ? String(10 ** power) : `1e${power}`;
      draw(svg, "text", { x: left - 8, y: Y(10 ** power) + 4, "text-anchor": "end" }, text);
    }
    const unit = 10 ** Math.floor(Math.log10((to - from) / 4));
    const tick = [1, 2, 2.5, 5, 10].map(part => part * unit).find(step => (to - from) / step <= 6);
    for (let x = Math.ceil(from / tick) * tick; x <= to + tick / 1e4; x += tick)
      draw(svg, "text", { x: X(x), y: top + h + 17, "text-anchor": "middle" }, show(Number(x.toPrecision(6))));
    draw(svg, "text", { x: left + w / 2, y: top + h + 36, "text-anchor": "middle" }, xName);
    draw(svg, "text", { x: 14, y: top + h / 2, "text-anchor": "middle", transform: `rotate(-90 14 ${top + h / 2})` }, yName);
    return { X, Y, left, top, w, h };
  };
  {
    const { counts, from, to, axis, limit, limit_name, note } = data.histogram;
    $("histogram-note").textContent = note;
    $("histogram").setAttribute("aria-label", note);
    const most = Math.max(1, ...counts);
    const { X, Y, top, h } = chart($("histogram"), from, to, 0, Math.ceil(Math.log10(most)), axis, "pixels");
    const edge = bin => X(from + bin / counts.length * (to - from));
    const bars = counts.map((count, bin) => {
      if (!count) return "";
      // A single pixel must be seen too: its bar starts a little below 1.
      return `M${edge(bin)} ${top + h}V${Math.min(Y(count), top + h - 2)}H${edge(bin + 1)}V${top + h}Z`;
    });
    draw($("histogram"), "path", { d: bars.join(""), class: "bars" });
    if (limit !== null) {
      draw($("histogram"), "line", { x1: X(limit), x2: X(limit), y1: top, y2: top + h, class: "limit" });
      const late = (limit - from) / (to - from) > 0.7;
      draw($("histogram"), "text", { x: X(limit) + (late ? -7 : 7), y: top + 14, class: "limit-name", "text-anchor": late ? "end" : "start" }, `${limit_name} = ${show(limit)}`);
    }
  }
  if (!data.convergence) {
    $("convergence").parentElement.remove();
    $("histogram").parentElement.classList.add("wide");
  } else {
    const { points, eps, note } = data.convergence;
    $("convergence-note").textContent = note;
    $("convergence").setAttribute("aria-label", note);
    const positive = points.map(([, change]) => change).concat(eps).filter(change => change > 0);
    const [low, high] = [Math.floor(Math.log10(Math.min(...positive))), Math.ceil(Math.log10(Math.max(...positive)))];
    const end = points.length ? points[points.length - 1][0] : 1;
    const { X, Y, left, w } = chart($("convergence"), 0, end, low, high, "time t", "change per step");
    const line = points.filter(([, change]) => change > 0).map(([t, change], i) => `${i ? "L" : "M"}${X(t)} ${Y(change)}`);
    draw($("convergence"), "path", { d: line.join(""), class: "curve" });
    draw($("convergence"), "line", { x1: left, x2: left + w, y1: Y(eps), y2: Y(eps), class: "limit" });
    draw($("convergence"), "text", { x: left + 6, y: Y(eps) - 6, class: "limit-name" }, `ε = ${show(eps)}`);
  }
})();
