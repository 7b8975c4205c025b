(() => {
  const $$ = (q) => [...document.querySelectorAll(q)];
  const form = document.querySelector('form');
  const ways = $$('.ways g[data-task]');
  let fixed = null;
  // Which ways are drawn at all, and which of them stand out.
  function filter() {
    const runs = new Set($$('input[name=run]').filter((i) => i.checked).map((i) => i.value));
    for (const way of ways) {
      const shown = runs.has(way.dataset.run) && (form.ways.value === '' || way.dataset.done === form.ways.value);
      way.toggleAttribute('hidden', !shown);
    }
    document.body.dataset.ground = form.ground.value;
  }
  function pick(task) {
    document.body.classList.toggle('picked', task !== null);
    for (const e of $$('[data-task]')) e.classList.toggle('on', e.dataset.task === task);
  }
  function fix(task) {
    fixed = fixed === task ? null : task;
    pick(fixed);
    history.replaceState(null, '', fixed === null ? location.pathname + location.search : '#' + encodeURIComponent(fixed));
  }
  for (const row of $$('tr[data-task]')) {
    const { task } = row.dataset;
    row.addEventListener('mouseenter', () => pick(task));
    row.addEventListener('mouseleave', () => pick(fixed));
    row.addEventListener('focus', () => pick(task));
    row.addEventListener('blur', () => pick(fixed));
    row.addEventListener('click', (e) => { if (!e.target.closest('a')) fix(task); });
    row.addEventListener('keydown', (e) => { if (e.key === 'Enter' && e.target === row) fix(task); });
  }
  for (const way of $$('.map g[data-task]')) way.addEventListener('click', () => fix(way.dataset.task));
  form.addEventListener('input', filter);
  form.addEventListener('submit', (e) => e.preventDefault());
  addEventListener('keydown', (e) => {
    const rel = { ArrowLeft: 'prev', ArrowRight: 'next' }[e.key];
    const link = rel && !e.target.closest('form') && document.querySelector(`a[rel=${rel}]`);
    if (link) location.href = link.href;
  });
  const named = () => {
    const task = decodeURIComponent(location.hash.slice(1));
    fixed = $$('tr[data-task]').some((r) => r.dataset.task === task) ? task : null;
    pick(fixed);
  };
  addEventListener('hashchange', named);
  filter();
  named();
})();
