(() => {
  const $ = (q, of = document) => of.querySelector(q);
  const $$ = (q, of = document) => [...of.querySelectorAll(q)];
  // Texts come from planners: they are set as text, never as markup.
  const make = (tag, text, className) => {
    const e = document.createElement(tag);
    if (text !== undefined && text !== null) e.textContent = text;
    if (className) e.className = className;
    return e;
  };
  const { compare, mark, button } = tables;

  // The tasks.
  const browser = $('#browser');
  const data = JSON.parse($('#data').textContent);
  const many = data.runs.length > 1;
  const PAGE = 100;
  const columns = [
    ['run', (r) => data.runs[r[0]][0]],
    ['task', (r) => r[1]],
    ['elevation', (r) => data.worlds[r[2]][1]],
    ['terrain', (r) => data.worlds[r[2]][2]],
    ['density', (r) => data.worlds[r[2]][3]],
    ['outcome', (r) => data.outcomes[r[3]]],
    ['cause', (r) => (r[8] === null ? '' : data.causes[r[8]][1])],
    ['time s', (r) => r[4], 1],
    ...data.measures.map(([head, digits], k) => [head, (r) => r[5][k], digits])
      .filter(([, of]) => data.rows.some((r) => of(r) !== null)),
    ['map', (r) => data.worlds[r[2]][4]],
    ['replay', (r) => r[7]],
  ].filter((c) => (many || c[0] !== 'run') && (c[0] !== 'replay' || data.rows.some((r) => r[7]))
    && (c[0] !== 'map' || data.worlds.some((w) => w[4]))
    && (c[0] !== 'cause' || data.rows.some((r) => r[8] !== null)));
  const levels = ['low', 'medium', 'high', 'sparse', 'medium', 'dense'];
  const rank = (v) => (levels.includes(v) ? levels.indexOf(v) % 3 : v);
  const form = $('form', browser);
  const tbody = $('tbody', browser);
  const option = (select, value, text) => {
    const o = make('option', text);
    o.value = value;
    select.append(o);
  };
  option(form.run, '', 'all');
  data.runs.forEach((r, k) => option(form.run, k, r[0]));
  for (const select of [form.does, form.not]) {
    option(select, '', 'any');
    data.runs.forEach((r, k) => option(select, k, r[0]));
  }
  if (!many) for (const select of [form.run, form.does, form.not]) select.parentElement.hidden = true;
  // Of each task the runs that do it, and those that have tried and don't.
  const done = new Map();
  for (const r of data.rows) {
    if (!done.has(r[1])) done.set(r[1], { does: new Set(), not: new Set() });
    if (r[3] === 0) done.get(r[1]).does.add(r[0]);
    else if (r[3] !== data.uncounted) done.get(r[1]).not.add(r[0]);
  }
  const parted = (r, kind) => form[kind].value === '' || done.get(r[1])[kind].has(Number(form[kind].value));
  // Between two runs only their own rows are of interest.
  const meant = (r) => form.does.value === '' || form.not.value === '' || [form.does.value, form.not.value].includes(String(r[0]));
  const sample = (k) => {
    const found = $(`[data-sample="${k}"]`);
    return found ? found.cloneNode(true) : '';
  };
  option(form.outcome, '', 'all');
  option(form.outcome, 'fail', 'failures');
  data.outcomes.forEach((o, k) => {
    if (data.rows.some((r) => r[3] === k)) option(form.outcome, k, o);
  });
  option(form.cause, '', 'anything');
  data.causes.forEach(([name, title], k) => {
    if (data.rows.some((r) => r[8] === k)) option(form.cause, name, title);
  });
  form.cause.parentElement.hidden = form.cause.options.length === 1;
  let sort = null;
  let chosen = [];
  let count = PAGE;
  const key = (r) => [r[1], ...data.worlds[r[2]].slice(0, 4), data.runs[r[0]][0], data.outcomes[r[3]], r[6]].join(' ').toLowerCase();
  const keys = data.rows.map(key);
  const format = (v, digits) => (v === null ? '–' : digits ? v.toFixed(digits).replace('-', '−') : v.toLocaleString('en').replaceAll(',', '\u2009'));
  function draw() {
    tbody.replaceChildren(...chosen.slice(0, count).map((r) => {
      const tr = make('tr');
      tr.tabIndex = 0;
      for (const [name, of, digits] of columns) {
        const v = of(r);
        if (name === 'replay' || name === 'map') {
          const td = make('td');
          if (v) {
            const a = make('a', name, name);
            const [world, task] = r[1].split('/').map(encodeURIComponent);
            a.href = name === 'map' ? `maps/${world}.html#${task}` : `replays/${world}/${task}.html`;
            td.append(a);
          }
          tr.append(td);
        } else if (name === 'outcome') {
          const td = make('td');
          td.append(make('i', undefined, 'swatch o' + r[3]), v);
          tr.append(td);
        } else if (name === 'run') {
          const td = make('td');
          td.append(sample(r[0]), v);
          tr.append(td);
        } else {
          tr.append(digits === undefined ? make('td', v) : make('td', format(v, digits), 'n'));
        }
      }
      const toggle = () => {
        const next = tr.nextElementSibling;
        if (next && next.className === 'detail') return next.remove();
        const detail = make('tr', undefined, 'detail');
        const td = make('td');
        td.colSpan = columns.length;
        if (r[6]) td.append(make('p', r[6]));
        td.append(make('code', `vb-harness replay ${data.runs[r[0]][1]} --task ${r[1]}`));
        detail.append(td);
        tr.after(detail);
      };
      tr.addEventListener('click', (e) => { if (!e.target.closest('a')) toggle(); });
      tr.addEventListener('keydown', (e) => { if (e.key === 'Enter' && e.target === tr) toggle(); });
      return tr;
    }));
    $('output', form).textContent = `${chosen.length} of ${data.rows.length}`;
    $('.more', browser).hidden = chosen.length <= count;
  }
  function filter() {
    const [run, outcome] = [form.run.value, form.outcome.value];
    const words = form.text.value.toLowerCase().split(/\s+/).filter(Boolean);
    chosen = data.rows.filter((r, k) => (run === '' || r[0] === Number(run))
      && (outcome === '' || (outcome === 'fail' ? r[3] !== 0 : r[3] === Number(outcome)))
      && (form.cause.value === '' || (r[8] !== null && data.causes[r[8]][0] === form.cause.value))
      && parted(r, 'does') && parted(r, 'not') && meant(r)
      && words.every((w) => keys[k].includes(w)));
    if (sort) chosen.sort((a, b) => sort.sign * compare(rank(sort.of(a)), rank(sort.of(b))));
    count = PAGE;
    draw();
  }
  const row = make('tr');
  const heads = columns.map(([name, of, digits]) => {
    const th = make('th', name, digits === undefined ? '' : 'n');
    button(th, () => {
      const sign = sort && sort.th === th ? -sort.sign : digits === undefined ? 1 : -1;
      sort = { th, of, sign };
      mark(heads, th, sign > 0);
      filter();
    });
    row.append(th);
    return th;
  });
  $('thead', browser).append(row);
  form.addEventListener('input', filter);
  form.addEventListener('submit', (e) => e.preventDefault());
  $('.more button', browser).addEventListener('click', () => { count += 5 * PAGE; draw(); });
  addEventListener('beforeprint', () => $$('tr.detail', tbody).forEach((e) => e.remove()));
  const show = (values) => {
    form.reset();
    for (const [name, value] of Object.entries(values)) form[name].value = value;
    filter();
    $('#tasks').scrollIntoView({ behavior: 'smooth' });
  };
  for (const b of $$('button[data-does]')) {
    b.addEventListener('click', () => show({ does: b.dataset.does, not: b.dataset.not }));
  }
  for (const b of $$('button[data-cause]')) {
    b.addEventListener('click', () => show({ run: many ? b.dataset.run : '', cause: b.dataset.cause }));
  }
  for (const w of $$('button[data-world]')) {
    w.addEventListener('click', () => show({ run: many ? w.dataset.run : '', text: w.dataset.world + '/' }));
  }
  filter();
  // A replay leads back to its task.
  const back = () => {
    const task = new URLSearchParams(location.hash.slice(1)).get('task');
    if (task) show({ text: task });
  };
  addEventListener('hashchange', back);
  back();
})();
