// The catalogue: rows, outlines and the card, for any number of sources. Rows are made for what is
// scrolled into view, outlines for the brightest of what the image shows.
const ROW = 27, MARGIN = 15, MOST_OUTLINES = 3000;
const column = name => data.columns.findIndex(one => one.name === name);
const flagsAt = column("flags"), brightness = [column("flux"), column("flux_aper_1"), 0].find(at => at >= 0);
const named = flags => data.flags.filter(([bit]) => flags & bit).map(([, name]) => name);
/** A value of a column; places on the sky have more digits than the rest, flags have names. */
const cell = (at, value) => {
  if (at === flagsAt) return value ? named(value).join(" ") : "";
  return value !== null && data.columns[at].digits > 9 ? value.toFixed(6) : show(value);
};
const all = data.rows.map((_, i) => i);
const byBrightness = [...all].sort((a, b) => (data.rows[b][brightness] ?? -Infinity) - (data.rows[a][brightness] ?? -Infinity));
let order = byBrightness, shown = null; // shown: which sources pass the filter; null where all do

// Filter: terms joined by commas, each `column < number` or the name of a flag.
const COMPARE = { "<": (a, b) => a < b, "<=": (a, b) => a <= b, ">": (a, b) => a > b, ">=": (a, b) => a >= b,
  "=": (a, b) => a === b, "!=": (a, b) => a !== b };
const term = text => {
  const [, not, word, sign, number] = text.match(/^(not\s+)?([a-z_0-9-]+)\s*(?:(<=|>=|!=|<|>|=)\s*([-+.\de]+))?$/i) ?? [];
  const flag = data.flags.find(([, name]) => name === word), at = column(word ?? "");
  if (flag && !sign) return row => Boolean(row[flagsAt] & flag[0]) !== Boolean(not);
  if (at < 0 || !sign || not || Number.isNaN(Number(number))) throw new Error(`${text}: neither a flag nor like 'snr > 10'`);
  return row => row[at] !== null && COMPARE[sign](row[at], Number(number));
};
const filter = () => {
  const texts = $("filter").value.split(",").map(text => text.trim()).filter(Boolean);
  try {
    const terms = texts.map(term);
    shown = terms.length ? data.rows.map(row => terms.every(holds => holds(row))) : null;
    $("filter").setCustomValidity("");
  } catch (error) {
    $("filter").setCustomValidity(error.message);
  }
  $("filter").title = $("filter").validationMessage || $("filter").dataset.help;
  fill();
  outline();
};

// Rows
const scroll = $("scroll"), body = $("rows"), rows = new Map();
let listed = [];
const row = (i, index) => {
  const line = make("tr", { tabindex: "-1", "data-source": i, "data-index": index, "aria-rowindex": index + 2 });
  line.append(...data.rows[i].map((value, at) => make("td", {}, cell(at, value))));
  if (i === hovered) line.classList.add("hover");
  if (i === chosen) line.classList.add("chosen");
  return line;
};
const space = count => make("tr", { class: "space", style: `height: ${count * ROW}px` });
const paint = () => {
  if (!listed.length) return;
  const focused = body.contains(document.activeElement) ? Number(document.activeElement.dataset.index) : null;
  const first = clamp(Math.floor(scroll.scrollTop / ROW) - MARGIN, 0, listed.length);
  const last = clamp(Math.ceil((scroll.scrollTop + scroll.clientHeight) / ROW) + MARGIN, 0, listed.length);
  rows.clear();
  const lines = listed.slice(first, last).map((i, k) => row(i, first + k));
  lines.forEach(line => rows.set(Number(line.dataset.source), line));
  body.replaceChildren(space(first), ...lines, space(listed.length - last));
  const entry = lines.find(line => Number(line.dataset.index) === focused) ?? lines.find(line => line.dataset.index === "0") ?? lines[0];
  entry.tabIndex = 0;
  if (focused !== null) entry.focus({ preventScroll: true });
};
const fill = () => {
  listed = shown ? order.filter(i => shown[i]) : order;
  const [n, total] = [listed.length, all.length];
  $("count").textContent = `${n < total ? `${n} of ` : ""}${total} source${total === 1 ? "" : "s"}`;
  const words = total ? "No source passes the filter." : "No sources were found.";
  if (!n) body.replaceChildren(make("tr", {}, make("td", { class: "empty", colspan: data.columns.length }, words)));
  scroll.scrollTop = 0;
  paint();
};
/** Brings a row into view; its place in the list. */
const reveal = index => {
  const [top, head] = [index * ROW, $("head").offsetHeight];
  if (top < scroll.scrollTop || top + ROW + head > scroll.scrollTop + scroll.clientHeight)
    scroll.scrollTop = top - (scroll.clientHeight - head) / 2;
  paint();
};

// Outlines
$("paths").setAttribute("transform", "scale(0.01)"); // they are in hundredths of a pixel
const paths = new Map();
const isVisible = ([left, top, right, bottom]) =>
  right >= view.x && left <= view.x + view.w && bottom >= view.y && top <= view.y + view.h;
const outline = () => {
  const within = byBrightness.filter(i => data.outlines[i] && (!shown || shown[i]) && isVisible(data.boxes[i]));
  const wanted = new Set(within.slice(0, MOST_OUTLINES).concat([hovered, chosen].filter(i => data.outlines[i])));
  for (const [i, path] of paths) if (!wanted.has(i)) { path.remove(); paths.delete(i); }
  for (const i of wanted) {
    if (paths.has(i)) continue;
    const path = draw($("paths"), "path", { d: data.outlines[i], "fill-rule": "evenodd", "data-source": i });
    if (i === chosen) path.classList.add("chosen");
    paths.set(i, path);
  }
  const hidden = within.length - MOST_OUTLINES;
  $("hidden").textContent = hidden > 0 ? `The ${MOST_OUTLINES} brightest of ${within.length} outlines; zoom in for the rest.` : "";
};
watchers.push(soon(outline));

let hovered = null, chosen = null;
const mark = (name, i, on) => [paths.get(i), rows.get(i)].forEach(element => element?.classList.toggle(name, on));
const hover = i => {
  if (hovered !== null) mark("hover", hovered, false);
  hovered = i;
  if (i === null) return;
  if (data.outlines[i] && !paths.has(i)) outline();
  mark("hover", i, true);
  paths.get(i)?.parentNode.append(paths.get(i));
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
  pairs(list, data.columns.map((one, at) => [one.name, `${cell(at, data.rows[i][at])} ${one.unit}`]).slice(0, 14));
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
  $("pointer").textContent = readOut(at);
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
  if (i !== null && listed.includes(i)) reveal(listed.indexOf(i));
});

// Pointer and keys on the rows
const open = i => {
  choose(i);
  if (!data.outlines[i]) return;
  visit(data.boxes[i]);
  outline();
};
body.addEventListener("pointerover", event => hover(source(event)));
body.addEventListener("pointerleave", () => hover(null));
body.addEventListener("focusin", event => hover(source(event)));
body.addEventListener("click", event => { if (source(event) !== null) open(source(event)); });
body.addEventListener("keydown", event => {
  const index = Number(event.target.closest("tr")?.dataset.index), page = Math.floor(scroll.clientHeight / ROW) - 2;
  const to = { ArrowDown: index + 1, ArrowUp: index - 1, PageDown: index + page, PageUp: index - page,
    Home: 0, End: listed.length - 1 }[event.key];
  if (to !== undefined && listed.length) {
    const next = clamp(to, 0, listed.length - 1);
    reveal(next);
    rows.get(listed[next])?.focus({ preventScroll: true });
  } else if ((event.key === "Enter" || event.key === " ") && source(event) !== null) {
    open(source(event));
  } else {
    return;
  }
  event.preventDefault();
});
scroll.addEventListener("scroll", soon(paint));
$("filter").addEventListener("input", filter);

// Columns sort by a click: down, then up. Missing values come last.
const heads = data.columns.map((one, at) => {
  const button = make("button", { title: one.description }, make("b", {}, one.name), make("small", {}, one.unit));
  const head = make("th", { scope: "col", "aria-sort": at === brightness ? "descending" : "none" }, button);
  button.addEventListener("click", () => {
    const down = head.getAttribute("aria-sort") !== "descending";
    heads.forEach(other => other.setAttribute("aria-sort", "none"));
    head.setAttribute("aria-sort", down ? "descending" : "ascending");
    order = [...all].sort((a, b) => {
      const [x, y] = [data.rows[a][at], data.rows[b][at]];
      if (x === null || y === null) return (x === null) - (y === null);
      return down ? y - x : x - y;
    });
    fill();
  });
  return head;
});
$("head").append(make("tr", {}, ...heads));
fill();
outline();

// Toolbar and keys
const flip = button => {
  const on = button.getAttribute("aria-pressed") !== "true";
  button.setAttribute("aria-pressed", on);
  return on;
};
const actions = {
  fit: () => fit(), in: () => zoom(1 / 1.5), out: () => zoom(1.5),
  outlines: () => sky.classList.toggle("bare", !flip($("outlines"))),
  invert: () => { $("frame").classList.toggle("inverted", flip($("invert"))); stretch(); },
};
Object.entries(actions).forEach(([id, action]) => $(id).addEventListener("click", action));
sky.addEventListener("keydown", event => {
  const step = view.w / 10;
  const keys = { "0": actions.fit, "+": actions.in, "=": actions.in, "-": actions.out, o: actions.outlines, i: actions.invert,
    ArrowLeft: () => move(-step, 0), ArrowRight: () => move(step, 0),
    ArrowUp: () => move(0, -step), ArrowDown: () => move(0, step) };
  if (keys[event.key] && !event.ctrlKey && !event.metaKey) { keys[event.key](); event.preventDefault(); }
});
