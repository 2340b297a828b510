// SPDX-License-Identifier: MIT
//
// Style and script of html_report(). The script reads what it needs from the sections that C++ wrote.
#pragma once

namespace skerry::render {

inline constexpr char kReportStyle[] = R"css(
:root { color-scheme: light dark; --bg:#f6f6f4; --card:#fff; --ink:#1b1b1b; --dim:#666; --line:#d8d8d4;
        --good:#0a7a55; --bad:#b3261e; --new:#8a5a00; --accent:#0b63b0; }
@media (prefers-color-scheme: dark) {
  :root { --bg:#17181a; --card:#212326; --ink:#ececec; --dim:#a0a0a0; --line:#3a3d42;
          --good:#52c79a; --bad:#ff8a80; --new:#f0bf60; --accent:#7fb8f0; } }
* { box-sizing:border-box }
body { margin:0; background:var(--bg); color:var(--ink); font:15px/1.45 system-ui,"DejaVu Sans",sans-serif }
main { max-width:1360px; margin:0 auto; padding:20px }
h1 { font-size:22px; margin:0 0 4px } h2 { font-size:17px; margin:0 }
p { margin:4px 0 } .dim { color:var(--dim) } code, pre { font:13px "DejaVu Sans Mono",monospace }
.totals { display:flex; gap:12px; flex-wrap:wrap; margin:14px 0 }
.totals div { background:var(--card); border:1px solid var(--line); border-radius:8px; padding:8px 14px }
.totals b { display:block; font-size:20px }
.good { color:var(--good) } .bad { color:var(--bad) } .new { color:var(--new) }
section { background:var(--card); border:1px solid var(--line); border-radius:10px; padding:14px 16px; margin:14px 0 }
section header { display:flex; gap:14px; align-items:baseline; flex-wrap:wrap }
.bar { display:flex; gap:6px; flex-wrap:wrap; margin:10px 0; align-items:center }
button { font:inherit; color:inherit; background:var(--bg); border:1px solid var(--line); border-radius:6px;
         padding:3px 10px; cursor:pointer }
button[aria-pressed=true] { border-color:var(--accent); color:var(--accent); font-weight:600 }
.stage { position:relative; display:grid; gap:8px }
.stage.side { grid-template-columns:1fr 1fr }
.stage figure { margin:0; position:relative } .stage img, .stage canvas { width:100%; height:auto; display:block }
figcaption { color:var(--dim); font-size:13px }
.over { position:relative; max-width:960px } .over .top { position:absolute; inset:0 auto auto 0 }
.over .rule { position:absolute; top:0; bottom:0; width:2px; background:#ff2bd6; transform:translateX(-1px) }
input[type=range] { width:260px }
.zoom { display:flex; gap:12px; flex-wrap:wrap; margin-top:12px } .zoom figure { margin:0 }
.zoom canvas { width:300px; image-rendering:pixelated; border:1px solid var(--line); display:block }
table { border-collapse:collapse; margin:8px 0 } td { padding:2px 14px 2px 0; vertical-align:top }
pre { margin:0; white-space:pre-wrap } .commands { margin-top:8px }
.small { display:grid; grid-template-columns:repeat(auto-fill,minmax(300px,1fr)); gap:12px }
.small figure { margin:0 } .small img { width:100%; border:1px solid var(--line); border-radius:6px; display:block }
[hidden] { display:none !important }
)css";

inline constexpr char kReportScript[] = R"js(
"use strict";
const root = document.documentElement;
const load = image => new Promise((done, fail) => {
  const settle = () => image.naturalWidth > 0 ? done(image) : fail(new Error("picture " + image.alt));
  if (image.complete) settle();
  else { image.onload = settle; image.onerror = settle; }
});

// Pixels of an image as [r, g, b, a, ...].
function pixels(image) {
  const canvas = document.createElement("canvas");
  canvas.width = image.naturalWidth; canvas.height = image.naturalHeight;
  const context = canvas.getContext("2d", { willReadFrequently: true });
  context.drawImage(image, 0, 0);
  return context.getImageData(0, 0, canvas.width, canvas.height);
}

// Fills a canvas with |a - b| times the gain; returns what was found.
function difference(a, b, canvas, gain, limit) {
  const width = Math.min(a.width, b.width), height = Math.min(a.height, b.height);
  canvas.width = width; canvas.height = height;
  const context = canvas.getContext("2d"), out = context.createImageData(width, height);
  let largest = 0, beyond = 0;
  for (let y = 0; y < height; ++y) for (let x = 0; x < width; ++x) {
    const i = 4 * (y * a.width + x), j = 4 * (y * b.width + x), o = 4 * (y * width + x);
    let most = 0;
    for (let k = 0; k < 4; ++k) {
      const d = Math.abs(a.data[i + k] - b.data[j + k]);
      if (k < 3) out.data[o + k] = Math.min(255, gain * d);
      most = Math.max(most, d);
    }
    out.data[o + 3] = 255;
    largest = Math.max(largest, most);
    beyond += most > limit;
  }
  context.putImageData(out, 0, 0);
  return { largest, beyond };
}

// A box of the image, enlarged without smoothing.
function enlarge(source, canvas, box) {
  const times = Math.max(1, Math.floor(300 / Math.max(box.w, box.h)));
  canvas.width = box.w * times; canvas.height = box.h * times;
  const context = canvas.getContext("2d");
  context.imageSmoothingEnabled = false;
  context.drawImage(source, box.x, box.y, box.w, box.h, 0, 0, canvas.width, canvas.height);
  return times;
}

class Comparison {
  constructor(section) {
    this.section = section;
    this.find = name => section.querySelector("[data-part=" + name + "]");
    this.limit = Number(section.dataset.limit);
    this.box = JSON.parse(section.dataset.box);
  }
  async start() {
    this.expected = await load(this.find("expected"));
    this.actual = await load(this.find("actual"));
    for (const copy of this.section.querySelectorAll("img[data-copy]")) {
      copy.src = this.find(copy.dataset.copy).src;
      await load(copy);
    }
    this.a = pixels(this.expected); this.b = pixels(this.actual);
    this.canvas = this.find("difference");
    this.gain = this.find("gain"); this.slider = this.find("slider");
    this.gain.oninput = () => this.draw();
    this.slider.oninput = () => this.slide();
    this.draw(); this.slide(); this.zoom();
    for (const button of this.section.querySelectorAll("button[data-mode]"))
      button.onclick = () => this.show(button.dataset.mode);
    this.show("side");
  }
  draw() {
    this.found = difference(this.a, this.b, this.canvas, Number(this.gain.value), this.limit);
    this.find("gain-text").textContent = "x" + this.gain.value;
  }
  slide() {
    const share = this.slider.value / 10;
    this.find("slide-top").style.clipPath = "inset(0 0 0 " + share + "%)";
    this.find("rule").style.left = share + "%";
  }
  zoom() {
    const width = Math.min(this.a.width, this.b.width), height = Math.min(this.a.height, this.b.height);
    const size = Math.max(this.box.w, this.box.h, 16) + 16;
    const w = Math.min(size, width), h = Math.min(size, height);
    const x = Math.max(0, Math.min(width - w, Math.round(this.box.x + (this.box.w - w) / 2)));
    const y = Math.max(0, Math.min(height - h, Math.round(this.box.y + (this.box.h - h) / 2)));
    this.window = { x, y, w, h };
    this.times = enlarge(this.expected, this.find("zoom-expected"), this.window);
    enlarge(this.actual, this.find("zoom-actual"), this.window);
    enlarge(this.canvas, this.find("zoom-difference"), this.window);
  }
  show(mode) {
    clearInterval(this.timer);
    this.mode = mode;
    for (const view of this.section.querySelectorAll("[data-view]")) view.hidden = view.dataset.view !== mode;
    for (const button of this.section.querySelectorAll("button[data-mode]"))
      button.setAttribute("aria-pressed", String(button.dataset.mode === mode));
    const top = this.find("blink-top");
    top.hidden = true;
    if (mode === "blink") this.timer = setInterval(() => {
      top.hidden = !top.hidden;
      this.find("blink-text").textContent = top.hidden ? "expected" : "actual";
    }, 500);
  }
  // Works every control; returns what is wrong.
  async selftest() {
    const wrong = [];
    const want = (fact, what) => { if (!fact) wrong.push(this.section.id + ": " + what); };
    want(this.found.largest === Number(this.section.dataset.largest), "largest difference " + this.found.largest);
    want(this.found.beyond === Number(this.section.dataset.beyond), "pixels beyond " + this.found.beyond);
    for (const mode of ["slider", "blink", "difference", "map", "side"]) {
      this.section.querySelector("button[data-mode=" + mode + "]").click();
      const seen = [...this.section.querySelectorAll("[data-view]")].filter(view => !view.hidden);
      want(seen.length === 1 && seen[0].dataset.view === mode, "view " + mode);
      if (mode !== "blink") continue;
      const top = this.find("blink-top");
      const before = top.hidden;
      await new Promise(done => setTimeout(done, 750));
      want(top.hidden !== before, "blinking");
    }
    this.slider.value = 250; this.slider.dispatchEvent(new Event("input"));
    want(this.find("slide-top").style.clipPath.includes("25%"), "slider");
    this.slider.value = 500; this.slider.dispatchEvent(new Event("input"));
    const zoomed = this.find("zoom-actual"), at = Math.floor(this.times / 2);
    const near = zoomed.getContext("2d").getImageData(at, at, 1, 1).data;
    const from = 4 * (this.window.y * this.b.width + this.window.x);
    for (let k = 0; k < 3; ++k) want(near[k] === this.b.data[from + k], "zoom channel " + k);
    return wrong;
  }
}

function copy(event) {
  const button = event.target, text = button.parentElement.querySelector("code").textContent;
  navigator.clipboard?.writeText(text).then(() => { button.textContent = "copied"; });
}

(async () => {
  const wrong = [];
  const comparisons = [...document.querySelectorAll("section[data-largest]")].map(s => new Comparison(s));
  await Promise.all(comparisons.map(comparison => comparison.start()));
  for (const button of document.querySelectorAll("button.copy")) button.onclick = copy;
  const images = [...document.images];
  for (const image of images) await load(image).catch(() => wrong.push("picture " + image.alt));
  if (location.hash !== "#selftest") return;
  for (const comparison of comparisons) wrong.push(...await comparison.selftest());
  root.dataset.verdict = wrong.length ? "bad: " + wrong.join("; ")
    : "good: " + comparisons.length + " comparisons, " + images.length + " pictures";
})().catch(error => { root.dataset.verdict = "bad: " + error; });
)js";

}  // namespace skerry::render
