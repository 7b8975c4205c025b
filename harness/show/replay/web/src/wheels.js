// What each wheel does at a time: its load as a bar, coloured by its slip, and how deep it is in soil.
import { gradient, scale } from './data.js';

const LIFTED = 0.02; // of a wheel's share of the weight: less, and it hangs in the air

const make = (tag, className, text = '') => Object.assign(document.createElement(tag), { className, textContent: text });

export class WheelPanel {
  constructor(host) {
    this.host = host;
  }

  // The rows of a run: one an axle, the left wheel left.
  make(run) {
    this.run = run;
    this.cells = [];
    this.host.replaceChildren();
    this.host.hidden = !run.contact;
    if (!run.contact) return;
    const key = make('figcaption', '');
    const bar = make('i', 'ramp');
    bar.style.background = gradient();
    const legend = make('span', 'key');
    legend.append('slip 0', bar, '1');
    key.append(make('span', '', 'wheels: load, slip, depth'), legend);
    this.host.append(key);
    run.vehicle.axles.forEach((name) => {
      const row = make('div', 'axle');
      row.append(make('span', 'name', name));
      for (const side of ['left', 'right']) {
        const cell = make('span', `wheel ${side}`);
        const [fill, text] = [make('i', ''), make('output', '')];
        cell.append(fill, text);
        row.append(cell);
        this.cells.push({ fill, text });
      }
      this.host.append(row);
    });
  }

  show(frame) {
    const { run, cells } = this;
    if (!run?.contact) return;
    const n = run.wheel_count;
    cells.forEach(({ fill, text }, w) => {
      const [load, slip, depth] = ['load', 'slip', 'depth'].map((what) => run.contact[what](n * frame + w));
      // A full bar is three times what a wheel bears on level ground.
      fill.style.width = `${Math.min(100, (100 * load * n) / 3)}%`;
      const [r, g, b] = scale(Math.abs(slip)).map((v) => Math.round(255 * v));
      fill.style.background = `rgb(${r},${g},${b})`;
      const sunk = depth >= 0.001 ? `, ${(100 * depth).toFixed(depth < 0.1 ? 1 : 0)} cm` : '';
      const spin = slip.toFixed(2).replace('-', '−');
      text.textContent = load < LIFTED / n ? `in the air, ${spin}` : `${(100 * load).toFixed(0)} %, ${spin}${sunk}`;
      text.title = `${(100 * load).toFixed(1)} % of the weight; slip ${spin}: 1 spins, −1 is locked; ${(100 * depth).toFixed(1)} cm in soil`;
    });
  }
}
