// Tables: a click on a head sorts, a field above finds rows, a list chooses verdicts. The page is whole without it.
(() => {
  const SMALL = 6; // rows: a table with no more is seen at once

  /** The number that a cell starts with ("3.000·10⁻⁹ [..]", "−0.5", "∞"), or NaN. */
  const numberOf = (text) => {
    const found = /^([−-]?)(∞|[\d.\u202f]+)(?:·10([−-]?\d+))?/.exec(text.trim());
    if (!found) return NaN;
    const size = found[2] === "∞" ? Infinity : Number(found[2].replace(/\u202f/g, ""));
    return (found[1] ? -1 : 1) * size * (found[3] ? 10 ** Number(found[3].replace("−", "-")) : 1);
  };

  /** Order of two cells: numbers by size and before words, words by alphabet, empty ones last. */
  const compare = (a, b) => {
    const x = numberOf(a), y = numberOf(b);
    if (!Number.isNaN(x) || !Number.isNaN(y)) return Number.isNaN(x) ? 1 : Number.isNaN(y) ? -1 : x - y || 0;
    return !a || !b ? (a ? -1 : b ? 1 : 0) : a.localeCompare(b, "en", { numeric: true });
  };

  const text = (row, column) => row.cells[column] ? row.cells[column].textContent : "";

  function sortable(table) {
    const body = table.tBodies[0], first = [...body.rows];
    [...table.tHead.rows[0].cells].forEach((head, column) => {
      const button = document.createElement("button");
      button.type = "button";
      button.className = "sort";
      button.append(...head.childNodes);
      head.append(button);
      button.addEventListener("click", () => {
        const now = head.getAttribute("aria-sort"), next = now === "ascending" ? "descending" : now ? null : "ascending";
        for (const other of table.tHead.rows[0].cells) other.removeAttribute("aria-sort");
        if (next) head.setAttribute("aria-sort", next);
        const sign = next === "descending" ? -1 : 1;
        const keyed = first.map((row) => [text(row, column), row]);
        if (next) keyed.sort((a, b) => (!a[0] || !b[0] ? compare(a[0], b[0]) : sign * compare(a[0], b[0])));
        body.append(...keyed.map((k) => k[1]));
      });
    });
  }

  function searchable(table, place) {
    const rows = [...table.tBodies].flatMap((b) => [...b.rows]), data = rows.filter((r) => !r.classList.contains("group"));
    const name = (place.getAttribute("aria-label") || "table").replace(/^Table /, "");
    const bar = document.createElement("div"), field = document.createElement("input"), count = document.createElement("output");
    bar.className = "find";
    field.type = "search";
    field.placeholder = "find rows";
    field.setAttribute("aria-label", `Find rows of ${name}`);
    bar.append(field);
    const kinds = [...new Set(data.map((r) => r.querySelector("td.v .verdict")?.className.split(" ")[1]).filter(Boolean))];
    let choice = null;
    if (kinds.length > 1 || data.some((r) => r.classList.contains("unexpected"))) {
      choice = document.createElement("select");
      choice.setAttribute("aria-label", `Verdicts of ${name}`);
      const words = { agrees: "agrees", differs: "differs", finding: "finding", undecided: "undecided" };
      const options = [["", "all verdicts"], ...kinds.map((k) => [k, words[k]]),
        ...(data.some((r) => r.classList.contains("unexpected")) ? [["unexpected", "not as expected"]] : [])];
      choice.append(...options.map(([value, label]) => new Option(label, value)));
      bar.append(choice);
    }
    bar.append(count);
    place.before(bar);
    const find = () => {
      const words = field.value.toLowerCase().split(/\s+/).filter(Boolean), kind = choice ? choice.value : "";
      let seen = 0;
      for (const row of data) {
        const whole = row.textContent.toLowerCase();
        const fits = words.every((w) => whole.includes(w)) && (!kind || (kind === "unexpected"
          ? row.classList.contains("unexpected") : row.querySelector(`td.v .${kind}`)));
        row.hidden = !fits;
        seen += fits ? 1 : 0;
      }
      for (const group of rows.filter((r) => r.classList.contains("group"))) { // a heading without rows says nothing
        let next = group.nextElementSibling, any = false;
        for (; next && !next.classList.contains("group"); next = next.nextElementSibling) any ||= !next.hidden;
        group.hidden = !any;
      }
      count.textContent = words.length || kind ? `${seen} of ${data.length} rows` : "";
    };
    field.addEventListener("input", find);
    if (choice) choice.addEventListener("change", find);
  }

  /** The rows in sight as CSV; a number with its interval is three cells. */
  function cells(table) {
    const plainNumber = (text) => text.replace(/\u202f/g, "").replace(/−/g, "-").replace(/·10(-?\d+)/, "e$1").replace("∞", "inf").replace("–", "");
    const rows = [...table.rows].filter((r) => !r.hidden), ranged = [...table.tHead.rows[0].cells].map((_, i) => rows.some((r) => r.cells[i] && r.cells[i].querySelector(".ci")));
    return rows.map((row) => [...row.cells].flatMap((cell, i) => {
      if (cell.closest("thead")) return ranged[i] ? [cell.textContent, `${cell.textContent} low`, `${cell.textContent} high`] : [cell.textContent];
      const range = cell.querySelector(".ci"), value = cell.classList.contains("n") ? plainNumber(cell.firstChild.parentNode.textContent.replace(range ? range.textContent : "", "").trim()) : cell.textContent.trim();
      const ends = range ? plainNumber(range.textContent).replace(/[[\]]/g, "").split(", ") : ["", ""];
      return ranged[i] ? [value, ...ends] : [value];
    }));
  }

  // The front page: which cards are in sight, by words and by how a study came out.
  const cards = [...document.querySelectorAll(".card")];
  if (cards.length > SMALL) {
    const bar = document.createElement("div"), field = document.createElement("input"), choice = document.createElement("select"), count = document.createElement("output");
    bar.className = "find of-cards";
    field.type = "search";
    field.placeholder = "find studies";
    field.setAttribute("aria-label", "Find studies");
    choice.setAttribute("aria-label", "How they came out");
    choice.append(new Option("all", ""), new Option("with findings", ".finding"), new Option("with rows that differ", ".differs"), new Option("with undecided rows", ".undecided"), new Option("not as expected", "strong"));
    bar.append(field, choice, count);
    document.querySelector(".cards").before(bar);
    const find = () => {
      const words = field.value.toLowerCase().split(/\s+/).filter(Boolean);
      for (const card of cards) {
        const whole = card.textContent.toLowerCase();
        card.hidden = !(words.every((w) => whole.includes(w)) && (!choice.value || card.querySelector(`.marks ${choice.value}`)));
      }
      const seen = cards.filter((c) => !c.hidden).length;
      count.textContent = seen < cards.length ? `${seen} of ${cards.length}` : "";
    };
    field.addEventListener("input", find);
    choice.addEventListener("change", find);
  }

  for (const place of document.querySelectorAll(".scroll")) {
    const table = place.querySelector("table");
    if (table && table.tHead && place.dataset.name) place.after(savers(place.dataset.name, { csv: () => cells(table) }));
    if (!table || !table.tHead || table.rows.length <= SMALL + 1) continue;
    if (!table.classList.contains("overview")) sortable(table);
    searchable(table, place);
  }
})();
