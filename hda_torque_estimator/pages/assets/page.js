/* Draw the plots of a page: zoom, hover, switch; by mouse, by touch and by keyboard. */
'use strict';
(() => {
  const read = name => JSON.parse(document.getElementById(name).textContent);
  const DRAWN = read('plots'), COLUMNS = read('columns');
  const LOOKS = {
    measured: {colour: '--ink', width: 2.4, dash: []},
    before: {colour: '--before', width: 1.4, dash: [7, 4]},
    before_other: {colour: '--before', width: 1.4, dash: [2, 3]},
    after: {colour: '--after', width: 1.4, dash: []},
    after_other: {colour: '--after', width: 1.4, dash: [8, 3, 2, 3]},
    third: {colour: '--unknown', width: 1.4, dash: [10, 3]},
    floor: {colour: '--floor', width: 1.1, dash: [4, 4]},
  };
  const HEIGHT = 250, BESIDE = 110, BELOW = 80;      // of a plot, and beside its axes [px]
  const SHEET = 900;                  // width of a plot on paper, whatever the screen [px]
  const FEW = 12;                     // values of a line that are drawn as points as well
  const colour = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  const faint = name => colour(name) + '38';
  const shown = value => value == null ? '–' : String(Number(value.toPrecision(4)));
  const drawn = [];

  /* The numbers of a column: a constant, written ones, or levels of which the last is a gap. */
  function numbers(packed, count) {
    if (typeof packed === 'number') return Array(count).fill(packed);
    if (Array.isArray(packed)) return packed;
    const {low, step, bytes, data} = COLUMNS[packed.at];
    const raw = Uint8Array.from(atob(data), letter => letter.charCodeAt(0));
    const levels = bytes === 4 ? new Uint32Array(raw.buffer) : new Uint16Array(raw.buffer);
    const gap = 2 ** (8 * bytes) - 1;
    return Array.from(levels, level => level === gap ? null : low + step * level);
  }

  /* Columns of a plot: every line, and after all lines the edges of their bands. */
  function columns(plot) {
    const of = packed => numbers(packed, plot.count), bands = [], edges = [];
    const data = [of(plot.x), ...plot.lines.map(line => of(line.y))];
    plot.lines.forEach((line, place) => {
      if (!line.low) return;
      data.push(of(line.low), of(line.high));
      edges.push(line.look, line.look);
      bands.push({series: [data.length - 1, data.length - 2], fill: () => faint(LOOKS[line.look].colour)});
    });
    return {data, bands, edges};
  }

  function series(line, plot) {
    const look = LOOKS[line.look], few = plot.count <= FEW;
    return {label: line.name || line.look, stroke: () => colour(look.colour), width: look.width,
            dash: look.dash, spanGaps: false, points: {show: few, size: 6},
            value: (u, v) => shown(v)};
  }

  function edge() {
    return {label: '', stroke: 'transparent', width: 0, auto: false, points: {show: false}};
  }

  /* All of each line is shown, and of a band what is between a twentieth of it on both sides:
     where little is known it is so wide that nothing else would be seen. */
  function reachOf(made, low, high, count) {
    if (low == null) return [low, high];
    const [from, to] = made.series[0].idxs, first = made.data.length - count;
    for (const column of made.data.slice(first)) {
      const seen = column.slice(from, to + 1).filter(value => value != null).sort((a, b) => a - b);
      if (!seen.length) continue;
      low = Math.min(low, seen[Math.floor(0.05 * (seen.length - 1))]);
      high = Math.max(high, seen[Math.ceil(0.95 * (seen.length - 1))]);
    }
    return uPlot.rangeNum(low, high, 0.1, true);
  }

  /* The font in which a label is no longer than its axis. */
  const ruler = document.createElement('canvas').getContext('2d');
  function fitting(label, room) {
    const font = size => `${size}px system-ui, sans-serif`;
    ruler.font = font(12);
    return font(Math.max(8, Math.min(12, Math.floor(12 * room / ruler.measureText(label).width))));
  }

  function axis(label, room, size, values) {
    return {label, size, values, labelSize: 24, labelFont: fitting(label, room),
            font: '12px system-ui, sans-serif', stroke: () => colour('--ink'),
            grid: {stroke: () => colour('--line'), width: 0.7},
            ticks: {stroke: () => colour('--line'), width: 0.7}};
  }

  const plain = (u, splits) => splits.map(v => String(Number(v.toPrecision(6))));
  const QUARTERS = ['0', 'π/2', 'π', '3π/2', '2π'];
  const turn = {splits: () => QUARTERS.map((_, k) => k * Math.PI / 2),
                values: () => QUARTERS};
  const powers = (u, splits) => splits.map(v => {
    const p = v > 0 ? Math.log10(v) : NaN;
    return Math.abs(p - Math.round(p)) < 1e-6 ? String(Number(v.toPrecision(3))) : '';
  });

  function options(plot, width, parts) {
    const log = plot.scale === 'log', logX = log || plot.scale === 'log_x';
    const x = {...axis(plot.x_label, width - BESIDE, 34, logX ? powers : plain),
               ...(plot.scale === 'turn' ? turn : {})};
    return {
      width, height: HEIGHT, bands: parts.bands,
      scales: {x: {time: false, distr: logX ? 3 : 1, range: (u, low, high) => [low, high]},
               y: log ? {distr: 3} : {range: (u, low, high) => reachOf(u, low, high, parts.edges.length)}},
      axes: [x, axis(plot.y_label, HEIGHT - BELOW, 58, log ? powers : plain)],
      series: [{label: plot.x_label, value: (u, v) => shown(v)}, ...plot.lines.map(line => series(line, plot)),
               ...parts.edges.map(edge)],
      cursor: {drag: {x: true, y: false}, ...(plot.scale === 'time' ? {sync: {key: 'time'}} : {})},
      legend: {live: true},
    };
  }

  /* The edges of bands, and the second of two floors, need no entry of their own. */
  function tidy(made, plot) {
    made.root.querySelectorAll('.u-legend .u-series').forEach((row, place) => {
      const line = plot.lines[place - 1];
      row.hidden = place > plot.lines.length || (line && !line.name);
      if (row.hidden) row.style.display = 'none';
    });
    mark(made, plot);
  }

  /* The legend shows each line as it is drawn now. */
  function mark(made, plot) {
    made.root.querySelectorAll('.u-legend .u-series').forEach((row, place) => {
      const line = plot.lines[place - 1];
      if (!line) return;
      const look = LOOKS[line.look], marker = row.querySelector('.u-marker');
      marker.style.borderStyle = look.dash.length ? 'dashed' : 'solid';
      marker.style.borderColor = colour(look.colour);
    });
  }

  function reach(made) {
    const x = made.data[0];
    return [x[0], x[x.length - 1]];
  }

  function look(made, low, high) {
    const [first, last] = reach(made), span = Math.min(high - low, last - first);
    low = Math.min(Math.max(low, first), last - span);
    made.setScale('x', {min: low, max: low + span});
  }

  const STEPS = {
    in: (low, high) => [low + 0.25 * (high - low), high - 0.25 * (high - low)],
    out: (low, high) => [low - 0.5 * (high - low), high + 0.5 * (high - low)],
    left: (low, high) => [low - 0.3 * (high - low), high - 0.3 * (high - low)],
    right: (low, high) => [low + 0.3 * (high - low), high + 0.3 * (high - low)],
  };
  const KEYS = {'+': 'in', '=': 'in', '-': 'out', ArrowLeft: 'left', ArrowRight: 'right',
                '0': 'all', Escape: 'all', Home: 'all'};

  function act(made, name) {
    if (name === 'all') return look(made, ...reach(made));
    const {min, max} = made.scales.x;
    if (made.scales.x.distr !== 3) return look(made, ...STEPS[name](min, max));
    look(made, ...STEPS[name](Math.log(min), Math.log(max)).map(Math.exp));
  }

  function drawnIn(box, plot, width) {
    const parts = columns(plot), made = new uPlot(options(plot, width, parts), parts.data, box);
    tidy(made, plot);
    if (plot.focus) look(made, ...plot.focus);
    return made;
  }

  function element(name, kind, text) {
    const made = document.createElement(name);
    made.className = kind;
    made.textContent = text;
    return made;
  }

  class Chart {
    constructor(figure) {
      this.box = figure.querySelector('.plot');
      this.plots = DRAWN[figure.dataset.chart];
      this.made = null;
      this.onPaper = false;
      this.printed = [];                  // elements that stand on paper only
      this.others = [];                   // and the plots in them
      this.buttons = [...figure.querySelectorAll('[data-choice]')];
      this.buttons.forEach(button => button.addEventListener('click', () => this.choose(button)));
      figure.querySelectorAll('[data-do]').forEach(button =>
        button.addEventListener('click', () => this.made && act(this.made, button.dataset.do)));
      this.box.addEventListener('keydown', event => this.typed(event));
      this.name = Object.keys(this.plots)[0];
      this.fit();
      new ResizeObserver(() => requestAnimationFrame(() => this.fit())).observe(this.box);
    }

    choose(button) {
      this.buttons.forEach(each => each.setAttribute('aria-pressed', String(each === button)));
      this.name = button.dataset.choice;
      this.draw(Math.floor(this.box.clientWidth));
    }

    typed(event) {
      if (!this.made || event.ctrlKey || event.metaKey || event.altKey) return;
      const name = KEYS[event.key];
      if (!name) return;
      event.preventDefault();
      act(this.made, name);
    }

    fit() {
      const width = this.onPaper ? SHEET : Math.floor(this.box.clientWidth);
      if (width < 50 || (this.made && this.made.width === width)) return;
      if (this.made) this.made.setSize({width, height: HEIGHT});
      else this.draw(width);
    }

    draw(width) {
      if (this.made) this.made.destroy();
      this.made = drawnIn(this.box, this.plots[this.name], width);
    }

    again() {
      if (!this.made) return;
      for (const [made, plot] of [[this.made, this.plots[this.name]], ...this.others]) {
        made.redraw(false, true);
        mark(made, plot);
      }
    }

    /* Nothing can be chosen on paper: all plots stand there, in their order, with their names. */
    unroll() {
      if (this.onPaper) return;
      this.onPaper = true;
      this.fit();
      if (this.buttons.length < 2) return;
      let last = null;                    // element, once the one that is shown has been passed
      const add = one => {
        if (last) last.after(one);
        else this.box.before(one);
        if (last) last = one;
        this.printed.push(one);
      };
      for (const [name, plot] of Object.entries(this.plots)) {
        add(element('p', 'choice', name));
        if (name === this.name) {
          last = this.box;
          continue;
        }
        const box = element('div', 'plot', '');
        add(box);
        this.others.push([drawnIn(box, plot, SHEET), plot]);
      }
    }

    rollUp() {
      this.others.forEach(([made]) => made.destroy());
      this.printed.forEach(one => one.remove());
      this.printed = [];
      this.others = [];
      this.onPaper = false;
      this.fit();
    }
  }

  /* What folds opens when the list of contents leads to it. */
  function unfold() {
    const at = location.hash && document.getElementById(location.hash.slice(1));
    if (at instanceof HTMLDetailsElement) at.open = true;
  }
  addEventListener('hashchange', unfold);
  unfold();

  document.querySelectorAll('.chart').forEach(figure => drawn.push(new Chart(figure)));

  /* Colours are asked for when drawing, so another theme, or paper, needs only another drawing. */
  const again = () => drawn.forEach(chart => chart.again());
  for (const query of ['(prefers-color-scheme: dark)', '(prefers-contrast: more)', 'print']) {
    matchMedia(query).addEventListener('change', again);
  }
  addEventListener('beforeprint', () => {
    document.querySelectorAll('.fold').forEach(each => {
      each.dataset.was = each.open;
      each.open = true;
    });
    drawn.forEach(chart => chart.unroll());
    again();
  });
  addEventListener('afterprint', () => {
    drawn.forEach(chart => chart.rollUp());
    document.querySelectorAll('.fold').forEach(each => { each.open = each.dataset.was === 'true'; });
    again();
  });
})();
