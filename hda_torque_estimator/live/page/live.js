// What the page shows: pictures of the arm come thirty times a second, words change as seldom as they must.
// A browser that draws more slowly leaves pictures out, so it never shows what was long ago.
import {Arm} from './arm.js';
import {Traces} from './traces.js';

const SILENT = 1.0;                 // seconds without a sample after which the arm is called silent
const AGAIN = 1000;                 // milliseconds until the page tries to connect again
const element = (name) => document.getElementById(name);
const LEVELS = ['well', 'warning', 'error'];
let arm = null, recording = null, latest = null;
const traces = new Traces(element('traces'));

try {
  arm = new Arm(element('arm'));
} catch {
  element('no-canvas').hidden = false;
}

function connect() {
  const socket = new WebSocket(`ws://${location.host}/pictures`);
  socket.onmessage = (event) => hear(JSON.parse(event.data));
  socket.onclose = () => {
    latest = null;                  // what was heard before is not shown as if it were now
    say('lost', 'the view has ended or was restarted: open its new address, or wait');
    setTimeout(connect, AGAIN);
  };
}

function hear(picture) {
  traces.add(picture);
  if (!latest) requestAnimationFrame(draw);
  latest = picture;
}

function draw() {
  const picture = latest;
  latest = null;
  if (picture) show(picture);
}

function show(picture) {
  showState(picture);
  showJoints(picture);
  showFacts(picture);
  showFlags(picture);
  showNodes(picture.nodes);
  showRecording(picture.recording);
  traces.draw();
  arm?.show(picture);
}

function showState({age, estimate}) {
  if (age === null) say('waiting', 'waiting for joint_states: is the arm or its driver running?');
  else if (age > SILENT) say('lost', `no sample for ${age.toFixed(0)} s`);
  else if (!estimate) say('waiting', 'the arm is heard; no torque estimator is running');
  else say('well', 'the arm and its estimator are running');
}

function say(kind, sentence) {
  const state = element('state');
  state.className = kind;
  write(state, sentence);
}

function showJoints({names, angles, estimate}) {
  const rows = names.map((name, at) => {
    const valid = estimate ? estimate.valid[at] : true;
    const torque = known(estimate?.torque[at], 2), deviation = known(estimate?.torque_std[at], 2);
    return {name, valid, cells: [known(angles?.[at], 3), estimate ? `${torque} ± ${deviation}` : '?',
      known(estimate?.external_torque[at], 2), known(scaled(estimate?.torsion[at], 1000), 3)]};
  });
  const body = element('joints');
  if (body.rows.length !== rows.length) {
    body.replaceChildren(...rows.map(() => {
      const row = document.createElement('tr');
      for (let cell = 0; cell < 5; cell += 1) row.insertCell();
      return row;
    }));
  }
  rows.forEach(({name, valid, cells}, at) => {
    body.rows[at].className = valid ? '' : 'doubted';
    [name, ...cells].forEach((text, column) => write(body.rows[at].cells[column], text));
  });
}

function showFacts({estimate, tip_force: force, rate}) {
  const words = {free: 'free', contact: 'contact', collision: 'collision: reset to go on'};
  const contact = element('contact');
  contact.className = estimate?.contact ?? '';
  write(contact, estimate ? words[estimate.contact] ?? estimate.contact : '');
  write(element('tip'), force?.some((value) => value != null) ? pushed(force) : 'unknown');
  const heavy = estimate?.payload != null && estimate.contact === 'free';      // a push looks like mass
  write(element('payload'), !heavy ? 'unknown'
    : `${known(estimate.payload, 2)} ± ${known(estimate.payload_std, 2)} kg`);
  write(element('rate'), rate ? `${rate.toFixed(0)} a second` : 'none');
}

function showFlags({estimate}) {
  const flags = estimate?.flags ?? [];
  list(element('flags'), flags.map((text) => ({kind: '', text})));
}

function showNodes(nodes) {
  list(element('nodes'), nodes.length ? nodes.map(({name, level, message, gone}) => ({
    kind: gone ? 'gone' : LEVELS[level] ?? 'error',
    text: `${name}: ${gone ? 'has not reported for 5 s' : message}`,
  })) : [{kind: 'warning', text: 'none has reported yet'}]);
}

function showRecording(now) {
  recording = now;
  const button = element('record');
  button.classList.toggle('on', Boolean(now));
  button.dataset.do = now ? 'stop' : 'record';
  write(button, now ? `Stop (${now.seconds.toFixed(0)} s)` : 'Record');
}

function list(parent, items) {
  if (parent.children.length !== items.length) {
    parent.replaceChildren(...items.map(() => document.createElement('li')));
  }
  items.forEach(({kind, text}, at) => {
    parent.children[at].className = kind;
    write(parent.children[at], text);
  });
}

function write(target, text) {
  if (target.textContent !== text) target.textContent = text;
}

function pushed(force) {
  const axes = force.map((value, axis) => value != null && `${'xyz'[axis]} ${known(value, 1)}`);
  return `${axes.filter(Boolean).join(', ')} N`;
}

function scaled(value, factor) {
  return value == null ? null : value * factor;
}

function known(value, digits) {
  return value == null ? '?' : value.toFixed(digits).replace(/^-(0\.?0*)$/, '$1');
}

async function act(button) {
  button.disabled = true;
  try {
    const response = await fetch(`/do/${button.dataset.do}`, {method: 'POST'});
    const text = await response.text();
    write(element('answer'), response.ok ? JSON.parse(text).message : text);
  } catch {
    write(element('answer'), 'the view does not answer');
  }
  button.disabled = false;
}

document.querySelectorAll('button').forEach((button) =>
  button.addEventListener('click', () => act(button)));
connect();
