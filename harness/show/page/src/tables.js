'use strict';
// Tables that are sorted by a click on a column's head: those written out in a page as table.sortable, and what others need.
const tables = (() => {
  const compare = (a, b) => {
    if (typeof a === 'number' && typeof b === 'number') return a - b;
    if (a === null || a === '') return b === null || b === '' ? 0 : 1;
    if (b === null || b === '') return -1;
    return String(a).localeCompare(String(b), 'en', { numeric: true });
  };
  const mark = (heads, on, up) => {
    for (const h of heads) h.removeAttribute('aria-sort');
    on.setAttribute('aria-sort', up ? 'ascending' : 'descending');
  };
  const button = (head, act) => {
    head.tabIndex = 0;
    head.addEventListener('click', act);
    head.addEventListener('keydown', (e) => {
      if (e.key === 'Enter' || e.key === ' ') { e.preventDefault(); act(); }
    });
  };

  // Tables written out in the page.
  for (const table of document.querySelectorAll('table.sortable')) {
    const heads = [...table.querySelectorAll('thead th')];
    const body = table.querySelector('tbody');
    const rows = [...body.rows];
    if (rows.length < 2) { table.classList.remove('sortable'); continue; }
    const value = (row, k) => {
      const cell = row.cells[k];
      if (!cell) return null;
      const text = cell.dataset.v ?? cell.textContent.trim().replace(/[\u2009]/g, '').replace('−', '-');
      return text !== '' && !Number.isNaN(Number(text)) ? Number(text) : text;
    };
    heads.forEach((head, k) => head.classList.contains('fixed') || button(head, () => {
      const up = head.getAttribute('aria-sort') !== 'ascending';
      mark(heads, head, up);
      rows.sort((a, b) => (up ? 1 : -1) * compare(value(a, k), value(b, k)));
      body.append(...rows);
    }));
  }
  return { compare, mark, button };
})();
