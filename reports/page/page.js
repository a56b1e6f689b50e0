// SPDX-License-Identifier: MIT
"use strict";
(() => {
  const root = document.documentElement;
  root.classList.add("js");

  // Which theme: the reader's last choice here, else what the system prefers.
  const kept = { get: () => { try { return localStorage.getItem("trilat-theme"); } catch { return null; } },
                 set: (t) => { try { localStorage.setItem("trilat-theme", t); } catch { /* not kept */ } } };
  const dark = matchMedia("(prefers-color-scheme: dark)");
  const button = document.getElementById("theme");
  const show = (theme) => {
    root.dataset.theme = theme;
    button.textContent = theme === "dark" ? "Light page" : "Dark page";
  };
  show(kept.get() || (dark.matches ? "dark" : "light"));
  dark.addEventListener("change", () => { if (!kept.get()) show(dark.matches ? "dark" : "light"); });
  button.addEventListener("click", () => {
    show(root.dataset.theme === "dark" ? "light" : "dark");
    kept.set(root.dataset.theme);
  });

  // A cell's value: the unrounded number where it is one; a number that is none comes last in either order.
  const value = (cell, numeric) => {
    if (!numeric) return cell.textContent.trim();
    const number = parseFloat(cell.dataset.v ?? cell.textContent);
    return Number.isNaN(number) ? null : number;
  };
  const collator = new Intl.Collator("en", { numeric: true });
  const sort = (th) => {
    const table = th.closest("table"), body = table.tBodies[0], column = th.cellIndex;
    const numeric = th.classList.contains("n");
    const rows = [...body.rows];
    rows.forEach((row, i) => { row.dataset.i ??= i; });
    const next = { none: "ascending", ascending: "descending", descending: "none" }[th.getAttribute("aria-sort")];
    for (const other of th.parentElement.cells) other.setAttribute("aria-sort", "none");
    th.setAttribute("aria-sort", next);
    const sign = next === "descending" ? -1 : 1;
    const keyed = rows.map((row) => [next === "none" ? null : value(row.cells[column], numeric), row]);
    keyed.sort(([a, x], [b, y]) => {
      if (next !== "none") {
        if ((a === null) !== (b === null)) return a === null ? 1 : -1;
        const order = a === null ? 0 : numeric ? a - b : collator.compare(a, b);
        if (order) return sign * order;
      }
      return x.dataset.i - y.dataset.i;
    });
    body.append(...keyed.map(([, row]) => row));
  };

  const count = (box) => {
    const rows = [...box.querySelectorAll("tbody tr")];
    const shown = rows.filter((row) => !row.classList.contains("away") && !row.classList.contains("off")).length;
    const output = box.querySelector(".shown");
    if (output) output.textContent = shown === rows.length ? `${rows.length} rows` : `${shown} of ${rows.length} rows`;
  };
  const filter = (input) => {
    const box = input.closest(".table"), words = input.value.toLowerCase().split(/\s+/).filter(Boolean);
    for (const row of box.querySelectorAll("tbody tr")) {
      row.dataset.text ??= row.textContent.toLowerCase();
      row.classList.toggle("away", !words.every((word) => row.dataset.text.includes(word)));
    }
    count(box);
  };

  const field = (text) => /[",\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
  const ends = (cell) => cell.dataset.ends === undefined ? "" : "," + cell.dataset.ends;
  const csv = (table) => [[...table.tHead.rows[0].cells].map((th) => field(th.dataset.key) + ends(th)),
    ...[...table.tBodies[0].rows].map((row) => [...row.cells].map((cell) => {
      const raw = cell.dataset.v ?? cell.textContent.trim();
      return (cell.classList.contains("n") && raw === "–" ? "" : field(raw)) + ends(cell);
    }))].map((row) => row.join(",") + "\r\n").join("");
  const copy = async (pressed) => {
    const text = csv(pressed.closest(".table").querySelector("table"));
    let done = true;
    try { await navigator.clipboard.writeText(text); } catch {
      const area = document.createElement("textarea");
      area.value = text;
      document.body.append(area);
      area.select();
      done = document.execCommand("copy");
      area.remove();
    }
    pressed.textContent = done ? "Copied" : "Not allowed here";
    setTimeout(() => { pressed.textContent = "Copy CSV"; }, 1500);
  };

  document.addEventListener("click", (event) => {
    const head = event.target.closest("thead th button");
    if (head) sort(head.parentElement);
    const copying = event.target.closest("button.copy");
    if (copying) copy(copying);
    const rest = event.target.closest("button.rest");
    if (rest) rest.closest(".table").classList.add("whole");
  });
  document.addEventListener("input", (event) => { if (event.target.matches(".bar input[type=search]")) filter(event.target); });

  const links = new Map([...document.querySelectorAll("nav.contents a")].map((a) => [a.hash.slice(1), a]));
  const seen = new IntersectionObserver((entries) => {
    for (const { isIntersecting, target } of entries) {
      if (!isIntersecting) continue;
      for (const a of links.values()) a.removeAttribute("aria-current");
      links.get(target.id)?.setAttribute("aria-current", "true");
    }
  }, { rootMargin: "0px 0px -75% 0px" });
  for (const section of document.querySelectorAll("main section[id]")) if (links.has(section.id)) seen.observe(section);

  root.dataset.interactiveMs = performance.now().toFixed(0);
})();
