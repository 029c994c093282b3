"""How the pages of all reports look: on light and dark screens, narrow ones, and on paper."""

STYLE_SHEET = """\
:root { color-scheme: light dark; --ink: #1a1a1e; --paper: #ffffff; --soft: #5c5c66;
  --line: #d9d9e0; --mark: #2b6cb0; --code: #f1f1f5; --shade: #00000026; }
@media (prefers-color-scheme: dark) {
  :root { --ink: #e6e6ea; --paper: #16161a; --soft: #a3a3ad; --line: #3a3a42; --mark: #6fa8dc;
    --code: #26262c; --shade: #ffffff30; } }
body { margin: 0; background: var(--paper); color: var(--ink);
  font: 16px/1.5 system-ui, -apple-system, "Segoe UI", sans-serif; }
body.ambiguous, body.insufficient_excitation, body.unknown { --mark: #e08214; }
main { max-width: 60rem; margin: 0 auto; padding: 2rem 1.25rem 4rem; }
h1 { font-size: 1.6rem; line-height: 1.25; margin: 0 0 0.75rem;
  border-left: 0.35rem solid var(--mark); padding-left: 0.9rem; }
h2 { font-size: 1.15rem; margin: 2.25rem 0 0.6rem; }
h3 { font-size: 1rem; margin: 0 0 0.4rem; }
h4 { font-size: 0.9rem; margin: 0.9rem 0 0.2rem; }
p { overflow-wrap: break-word; }
.lead { font-size: 1.05rem; }
article { border: 1px solid var(--line); border-left: 0.2rem solid var(--mark);
  border-radius: 4px; padding: 0.8rem 1rem; margin: 0 0 1rem; }
article > p { margin: 0.4rem 0; }
article figure { margin: 0.8rem 0 0; }
.wide { overflow-x: auto; background:
  linear-gradient(to left, var(--paper) 40%, transparent) right / 2rem 100% no-repeat local,
  linear-gradient(to left, var(--shade), transparent) right / 0.8rem 100% no-repeat; }
table { border-collapse: collapse; font-size: 0.9rem; width: 100%;
  font-variant-numeric: tabular-nums; }
th { text-align: left; font-weight: 600; color: var(--soft); }
th, td { padding: 0.35rem 0.9rem 0.35rem 0; vertical-align: top;
  border-bottom: 1px solid var(--line); }
table.facts { width: auto; }
small { color: var(--soft); }
code { background: var(--code); border-radius: 3px; padding: 0.05rem 0.3rem; }
code { overflow-wrap: anywhere; }
.number { white-space: nowrap; }
figure { margin: 1.5rem 0 2rem; }
figure > div { overflow-x: auto; }
figure svg { display: block; max-width: 100%; height: auto; }
figcaption { color: var(--soft); font-size: 0.9rem; max-width: 46rem; margin-top: 0.4rem; }
@media (max-width: 40rem) {
  main { padding: 1.25rem 0.9rem 3rem; }
  h1 { font-size: 1.3rem; }
  article { padding: 0.6rem 0.7rem; }
  th, td { padding-right: 0.6rem; }
  figure svg { max-width: none; width: 34rem; } }
@media print {
  :root { --ink: #000000; --paper: #ffffff; --soft: #333333; --line: #bbbbbb; --code: #eeeeee; }
  body { font-size: 10pt; }
  main { max-width: none; padding: 0; }
  article, figure, tr { break-inside: avoid; }
  h2, h3 { break-after: avoid; }
  .wide { overflow: visible; background: none; }
  figure svg { max-width: 100%; width: auto; }
  .number { white-space: normal; } }
"""
