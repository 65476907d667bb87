// SPDX-License-Identifier: Apache-2.0
"use strict";
(async () => {
  const body = document.body, root = document.documentElement;
  const fail = (what) => { body.dataset.error = `${body.dataset.error ?? ""}${what}\n`; };
  addEventListener("error", (event) => fail(event.message));
  addEventListener("unhandledrejection", (event) => fail(String(event.reason)));
  addEventListener("securitypolicyviolation", (event) => fail(`refused ${event.blockedURI}`));

  // Numbers: 16-bit differences, each array scaled to its own range (html/arrays.py).
  const GAP = 65535;
  const packed = Uint8Array.from(atob(document.getElementById("numbers").textContent.trim()), (c) => c.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  const codes = new Uint16Array(await new Response(stream).arrayBuffer());
  const array = ([begin, length, low, step]) => {
    const values = new Array(length);
    for (let i = 0, code = 0; i < length; i++) {
      code = (code + codes[begin + i]) & GAP;
      values[i] = code === GAP ? null : low + step * code;
    }
    return values;
  };

  // Theme: the system's until the button is pressed; paper is always light.
  const dark = matchMedia("(prefers-color-scheme: dark)"), drawing = lceFigures(array);
  const setTheme = (theme) => { root.dataset.theme = theme; drawing.redraw(); };
  setTheme(dark.matches ? "dark" : "light");
  document.getElementById("theme").onclick = () => setTheme(root.dataset.theme === "dark" ? "light" : "dark");
  dark.onchange = () => setTheme(dark.matches ? "dark" : "light");
  let onScreen = null;
  addEventListener("beforeprint", () => { onScreen = root.dataset.theme; setTheme("light"); });
  addEventListener("afterprint", () => setTheme(onScreen));

  const places = document.querySelectorAll("figure[data-figure]");
  body.dataset.figures = places.length;
  await drawing.draw(places, JSON.parse(document.getElementById("figures").textContent));
  await new Promise((next) => setTimeout(next, 0));
  if (location.hash === "#check") body.dataset.inked = drawing.plots.filter(drawing.inked).length;
  body.dataset.drawn = drawing.plots.length;
})();
