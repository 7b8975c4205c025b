(() => {
  const $ = (q, of = document) => of.querySelector(q);
  const $$ = (q, of = document) => [...of.querySelectorAll(q)];
  const form = $('#filter');
  const boards = $$('.board');
  const keys = ['suite', 'vehicle', 'division'];
  if (form) {
    for (const key of keys) {
      const add = (value, text) => {
        const o = document.createElement('option');
        o.value = value;
        o.textContent = text;
        form[key].append(o);
      };
      add('', 'all');
      const values = [...new Set(boards.map((b) => b.dataset[key]))].sort();
      for (const v of values) add(v, v);
      form[key].parentElement.hidden = values.length < 2;
    }
    form.hidden = boards.length < 2;
    const filter = () => {
      for (const b of boards) b.hidden = keys.some((k) => form[k].value && form[k].value !== b.dataset[k]);
      $('output', form).textContent = `${boards.filter((b) => !b.hidden).length} of ${boards.length} boards`;
    };
    form.addEventListener('input', filter);
    form.addEventListener('submit', (e) => e.preventDefault());
    filter();
  }
})();
