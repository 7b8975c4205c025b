'use strict';
(() => {
  const $ = (q, of = document) => of.querySelector(q);
  const $$ = (q, of = document) => [...of.querySelectorAll(q)];
  const grid = $('.worlds');
  const cards = $$('.card');
  const order = new Map(cards.map((c, k) => [c, k]));
  const dialog = $('#large');
  const shown = () => $$('.card:not([hidden])', grid);

  // Filters: of each label, the pressed values; none pressed means all.
  const wanted = { elevation: new Set(), terrain: new Set(), density: new Set() };
  function filter() {
    for (const card of cards) {
      card.hidden = !Object.entries(wanted).every(([key, set]) => !set.size || set.has(card.dataset[key]));
    }
    const n = shown().length;
    $('.count b').textContent = n;
    $('.none').hidden = n > 0;
  }
  for (const field of $$('[data-filter]')) {
    field.addEventListener('click', (event) => {
      const button = event.target.closest('button');
      if (!button) return;
      const set = wanted[field.dataset.filter];
      const on = !set.has(button.value);
      set[on ? 'add' : 'delete'](button.value);
      button.setAttribute('aria-pressed', on);
      filter();
    });
  }

  $('[data-choice=ground]').addEventListener('click', (event) => {
    const button = event.target.closest('button');
    if (!button) return;
    document.body.dataset.ground = button.value;
    for (const b of $$('button', event.currentTarget)) b.setAttribute('aria-pressed', b === button);
  });
  $('[data-toggles]').addEventListener('click', (event) => {
    const button = event.target.closest('button');
    if (!button) return;
    const off = document.body.classList.toggle('no-' + button.value);
    button.setAttribute('aria-pressed', !off);
  });
  $('.sort select').addEventListener('change', (event) => {
    const key = event.target.value;
    const by = (c) => (key ? Number(c.dataset[key]) : order.get(c));
    grid.prepend(...cards.slice().sort((a, b) => by(a) - by(b) || order.get(a) - order.get(b)));
  });

  // The larger view.
  let current = null;
  function open(card) {
    current = card;
    const stage = $('.stage', dialog);
    stage.className = 'stage';
    stage.replaceChildren($('.map', card).cloneNode(true));
    $('h2', dialog).replaceChildren(...$('h3', card).cloneNode(true).childNodes);
    const side = $('.side', dialog);
    side.replaceChildren($('template', card).content.cloneNode(true));
    let fixed = null;
    const pick = (id) => {
      stage.classList.toggle('picked', id !== null);
      for (const e of $$('[data-task]', dialog)) e.classList.toggle('on', e.dataset.task === id);
    };
    for (const row of $$('tr[data-task]', side)) {
      const id = row.dataset.task;
      row.addEventListener('mouseenter', () => pick(id));
      row.addEventListener('mouseleave', () => pick(fixed));
      row.addEventListener('focus', () => pick(id));
      row.addEventListener('blur', () => pick(fixed));
      row.addEventListener('click', () => pick((fixed = fixed === id ? null : id)));
    }
    if (!dialog.open) dialog.showModal();
    dialog.scrollTop = 0;
    history.replaceState(null, '', '#' + card.id);
  }
  function go(step) {
    if (!step) return dialog.close();
    const all = shown();
    if (all.length) open(all[(all.indexOf(current) + step + all.length) % all.length]);
  }
  for (const card of cards) $('.open', card).addEventListener('click', () => open(card));
  $('nav', dialog).addEventListener('click', (event) => {
    const button = event.target.closest('button');
    if (button) go(Number(button.dataset.go));
  });
  dialog.addEventListener('click', (event) => { if (event.target === dialog) dialog.close(); });
  dialog.addEventListener('keydown', (event) => {
    if (event.key === 'ArrowLeft') go(-1);
    if (event.key === 'ArrowRight') go(1);
  });
  dialog.addEventListener('close', () => {
    history.replaceState(null, '', location.pathname + location.search);
    if (current && !current.hidden) $('.open', current).focus();
  });
  const named = () => {
    const card = cards.find((c) => '#' + c.id === location.hash);
    if (card) open(card);
  };
  addEventListener('hashchange', named);
  named();
})();
