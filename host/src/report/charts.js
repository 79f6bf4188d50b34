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
