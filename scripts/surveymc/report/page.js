// The page: theme, where the reader is, enlarged figures, what is saved, and the interactive drawings.
(() => {
  const root = document.documentElement, button = document.getElementById("theme");
  const preferred = () => (matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light");
  const dark = () => (root.dataset.theme || preferred()) === "dark";
  const label = () => {
    button.textContent = dark() ? "Light" : "Dark";
    button.setAttribute("aria-label", `Switch to ${dark() ? "light" : "dark"} colours`);
  };
  try {
    const kept = localStorage.getItem("surveymc-theme");
    if (kept) root.dataset.theme = kept;
  } catch { /* some browsers give no storage to files */ }
  button.addEventListener("click", () => {
    root.dataset.theme = dark() ? "light" : "dark";
    try { localStorage.setItem("surveymc-theme", root.dataset.theme); } catch { /* as above */ }
    label();
    document.dispatchEvent(new Event("themechange"));
  });
  button.hidden = false;
  label();

  const links = new Map([...document.querySelectorAll("nav a[href^='#']")].map((a) => [a.getAttribute("href").slice(1), a]));
  const seen = new Set();
  const here = new IntersectionObserver((entries) => {
    for (const e of entries) e.isIntersecting ? seen.add(e.target.id) : seen.delete(e.target.id);
    const first = [...links.keys()].find((id) => seen.has(id));
    for (const [id, a] of links) id === first ? a.setAttribute("aria-current", "true") : a.removeAttribute("aria-current");
  }, { rootMargin: "-10% 0px -70% 0px" });
  for (const id of links.keys()) {
    const part = document.getElementById(id);
    if (part) here.observe(part);
  }
  const contents = document.getElementById("contents");
  if (contents && matchMedia("(max-width: 60rem)").matches) contents.open = false;

  // A figure in the whole window, and never more than that: nothing of it is cut.
  const large = document.getElementById("large"), picture = document.createElement("img");
  large.firstElementChild.append(picture);
  for (const b of document.querySelectorAll("button.figure")) {
    b.addEventListener("click", () => {
      picture.src = b.firstElementChild.src;
      picture.alt = b.firstElementChild.alt;
      large.showModal();
    });
  }
  large.addEventListener("click", () => large.close());

  // A figure is an SVG or a PNG; what it was drawn from is in the tables.
  for (const figure of document.querySelectorAll("figure.plot[id]")) {
    const image = figure.querySelector("img"), what = { png: () => canvasOf(image.src, image.naturalWidth, image.naturalHeight) };
    const place = savers(figure.id, what), head = "data:image/svg+xml,";
    if (image.src.startsWith(head)) {
      const b = make("button", { type: "button", "aria-label": `Save ${figure.id} as SVG` }, ["SVG"], true);
      b.addEventListener("click", () => download(`${document.body.dataset.file}-${figure.id}.svg`, decodeURIComponent(image.src.slice(head.length)), "image/svg+xml"));
      place.append(b);
    }
    figure.append(place);
  }

  // All at once, so that no part of the page moves when a reader comes to it.
  const KINDS = { map: mapExplorer, ellipse: ellipseExplorer, wells: wellsExplorer, cylinder: cylinderExplorer };
  for (const place of document.querySelectorAll("[data-source]")) {
    KINDS[place.dataset.kind](place, JSON.parse(document.getElementById(place.dataset.source).textContent), stateOf(place.id));
  }
  // "#ID;key=value": the place of a drawing with what it shows.
  const asked = location.hash.slice(1).split(";");
  if (asked.length > 1) document.getElementById(asked[0])?.scrollIntoView();
  addEventListener("hashchange", () => { if (location.hash.includes(";")) location.reload(); });

  // Paper has what is open, and no drawing that asks for choices: what stands folded is a line with its counts.
  addEventListener("beforeprint", () => { for (const i of document.images) i.loading = "eager"; });
})();
