"use strict";
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
const clamp = (value, least, most) => Math.min(most, Math.max(least, value));
const pairs = (list, entries) => entries.forEach(([name, value]) =>
  list.append(make("dt", {}, name), make("dd", {}, value)));
/** Calls `work` once in a frame's time, however often it is asked for. */
const soon = work => {
  let due = false;
  return () => {
    if (due) return;
    due = true;
    setTimeout(() => { due = false; work(); }, 16);
  };
};

// Head, parameters, provenance
document.title = `${data.title} · Skyfront`;
$("title").textContent = data.title;
data.facts.forEach(({ name, value, alert }) => $("facts").append(
  make("div", alert ? { class: "alert" } : {}, make("dt", {}, name), make("dd", {}, show(value)))));
data.parameters.forEach(({ name, value, unit, help }) => $("parameters").append(
  make("dt", {}, name), make("dd", {}, `${value} ${unit}`, make("small", {}, help))));
pairs($("provenance"), data.provenance);
