// Sections with all words of the query; those with them in their heading, or among its everyday words, first.
const root = document.body.dataset.root;
const folded = (text) => text.toLowerCase().normalize("NFD").replace(/[\u0300-\u036f]/g, "");
for (const field of document.querySelectorAll('nav input[type="search"]')) {
  const hits = field.nextElementSibling;
  field.addEventListener("input", () => {
    const wanted = folded(field.value).split(/\s+/).filter(Boolean);
    const score = (section) => {
      const title = folded(`${section.title} ${section.also}`), words = folded(`${section.words} ${section.also}`);
      if (!wanted.every((word) => words.includes(word))) return 0;
      return 1 + wanted.filter((word) => title.includes(word)).length;
    };
    const found = wanted.length ? sections.map((section) => [score(section), section]).filter(([points]) => points > 0) : [];
    found.sort((one, other) => other[0] - one[0]);
    hits.replaceChildren(...found.slice(0, 12).map(([, section]) => {
      const row = document.createElement("li"), link = document.createElement("a"), page = document.createElement("span");
      link.href = `${root}/${section.at}`;
      link.textContent = section.title;
      page.textContent = section.page;
      link.append(page);
      row.append(link);
      return row;
    }));
  });
}

// The current page, and its headings, are in sight.
document.querySelector("nav.side .within:last-of-type, nav.side [aria-current]")?.scrollIntoView({ block: "nearest" });
document.querySelector("nav.side [aria-current]")?.scrollIntoView({ block: "nearest" });
