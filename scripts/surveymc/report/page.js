// The page: theme, where the reader is, enlarged figures, and the interactive drawings once they come into sight.
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
  });
  button.hidden = false;
  label();

  const links = new Map([...document.querySelectorAll("nav a")].map((a) => [a.getAttribute("href").slice(1), a]));
  const seen = new Set();
  const here = new IntersectionObserver((entries) => {
    for (const e of entries) e.isIntersecting ? seen.add(e.target.id) : seen.delete(e.target.id);
    const first = [...links.keys()].find((id) => seen.has(id));
    for (const [id, a] of links) id === first ? a.setAttribute("aria-current", "true") : a.removeAttribute("aria-current");
  }, { rootMargin: "-10% 0px -70% 0px" });
  for (const id of links.keys()) {
    const part = document.getElementById(id);
    if (part && part.matches("article, #overview")) here.observe(part);
  }
  if (matchMedia("(max-width: 60rem)").matches) document.getElementById("contents").open = false;

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

  const start = (place) => {
    if (place.dataset.started) return;
    place.dataset.started = "1";
    const data = JSON.parse(document.getElementById(place.dataset.source).textContent);
    (place.dataset.kind === "map" ? mapExplorer : ellipseExplorer)(place, data);
  };
  const places = [...document.querySelectorAll("[data-source]")];
  const near = new IntersectionObserver((entries) => {
    for (const e of entries.filter((e) => e.isIntersecting)) {
      near.unobserve(e.target);
      start(e.target);
    }
  }, { rootMargin: "800px" });
  for (const p of places) near.observe(p);
  // Paper has what is open, and no drawing that asks for choices: what stands folded is a line with its counts.
  addEventListener("beforeprint", () => { for (const i of document.images) i.loading = "eager"; });
})();
