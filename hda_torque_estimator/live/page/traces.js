// Torques of the joints over the last seconds.
/* global uPlot */
const SECONDS = 20;
const COLOURS = ['#2b6cb0', '#d95f02', '#1b9e77', '#7570b3', '#e7298a', '#66a61e', '#a6761d'];

export class Traces {
  constructor(element) {
    this.element = element;
    this.names = [];
    this.data = [[]];
    new ResizeObserver(() => this.fit()).observe(element);
  }

  add(picture) {
    if (picture.names.join() !== this.names.join()) this.build(picture.names);
    const now = performance.now() / 1000;
    this.data[0].push(now);
    picture.names.forEach((_, at) => this.data[at + 1].push(picture.estimate?.torque[at] ?? null));
    const first = this.data[0].findIndex((time) => time >= now - SECONDS);
    if (first > 0) this.data = this.data.map((column) => column.slice(first));
  }

  fit() {
    const width = Math.max(this.element.clientWidth, 50);
    if (this.plot && width !== this.plot.width) this.plot.setSize({width, height: 190});
  }

  draw() {
    const now = this.data[0].at(-1);
    this.plot.setData([this.data[0].map((time) => time - now), ...this.data.slice(1)]);
  }

  build(names) {
    this.names = names;
    this.data = [[], ...names.map(() => [])];
    this.element.replaceChildren();
    const ink = () => getComputedStyle(document.body).getPropertyValue('--soft');   // light or dark, as of now
    const axis = {stroke: ink, grid: {stroke: '#88888833', width: 1}, ticks: {show: false}};
    this.plot = new uPlot({
      width: Math.max(this.element.clientWidth, 50), height: 190,
      scales: {x: {time: false, range: [-SECONDS, 0]}}, cursor: {show: false}, legend: {live: false},
      axes: [{...axis, values: (_, ticks) => ticks.map((tick) => `${tick} s`)},
        {...axis, size: 55, label: 'torque [N·m]', labelSize: 18}],
      series: [{}, ...names.map((name, at) => ({
        label: name, stroke: COLOURS[at % COLOURS.length], width: 1.5, points: {show: false}}))],
    }, this.data, this.element);
  }
}
