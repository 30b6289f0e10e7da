"""The style sheet of the page: light and dark, wide and narrow, screen and paper."""

STYLE = """
:root { color-scheme: light dark;
  --text: #1d2126; --dim: #5a646e; --back: #ffffff; --line: #d9dee3; --soft: #f4f6f8; --grid: #e8ecef;
  --good: #1a7f4b; --part: #8a6100; --band: #5b4bb7; --bad: #b3261e; --fail: #b3261e; --failback: #fdecea; --paper: #c2185b;
  --c0: #1f6fb4; --c1: #d3660a; --c2: #23855a; --c3: #7b4fb0; --c4: #0f8b8d; --c5: #8a939b; }
@media (prefers-color-scheme: dark) { :root {
  --text: #e4e7ea; --dim: #9fa9b2; --back: #14171a; --line: #333a41; --soft: #1d2226; --grid: #262c31;
  --good: #5fce93; --part: #e5b454; --band: #b1a5ff; --bad: #ff8a80; --fail: #ff8a80; --failback: #3a1a18; --paper: #ff7fae;
  --c0: #6db3f2; --c1: #ffa257; --c2: #62cf99; --c3: #c09bf2; --c4: #5fd0d2; --c5: #87919a; } }
* { box-sizing: border-box; }
html { scroll-behavior: smooth; scroll-padding-top: 1rem; }
body { margin: 0 auto; padding: 1.4rem 1rem 5rem; max-width: 76rem; background: var(--back); color: var(--text);
       font: 16px/1.55 system-ui, -apple-system, "Segoe UI", Roboto, sans-serif; overflow-wrap: anywhere; }
h1 { font-size: 1.75rem; line-height: 1.2; margin: .2rem 0 .4rem; }
h2 { font-size: 1.3rem; line-height: 1.25; margin: 0 0 .5rem; }
h3 { font-size: 1rem; margin: 1.4rem 0 .4rem; } p { margin: .5rem 0; max-width: 48rem; } .dim { color: var(--dim); }
a { color: var(--c0); } code, pre { font: .86em/1.5 ui-monospace, "SF Mono", Menlo, Consolas, monospace; }
pre { background: var(--soft); padding: .7rem .8rem; border-radius: 6px; margin: .5rem 0; white-space: pre-wrap; }
section { margin: 2.6rem 0 0; padding-top: 1.2rem; border-top: 1px solid var(--line); }
.number { color: var(--dim); font-weight: 500; margin-right: .5rem; }
.counts { display: flex; flex-wrap: wrap; gap: .5rem; margin: 1rem 0; padding: 0; list-style: none; }
.counts li { padding: .35rem .8rem; border: 1px solid var(--line); border-radius: 999px; background: var(--soft); }
.counts b { font-variant-numeric: tabular-nums; margin-right: .3rem; }
.changed { border-left: 4px solid var(--part); background: var(--soft); padding: .5rem .9rem; border-radius: 0 6px 6px 0; }
nav ol { columns: 20rem; padding: 0; margin: .6rem 0; list-style: none; } nav li { break-inside: avoid; padding: .12rem 0; }
nav a { text-decoration: none; color: inherit; } nav a:hover { text-decoration: underline; }
nav .dots { letter-spacing: .1em; margin-left: .4rem; }
.good { color: var(--good); } .part { color: var(--part); } .band { color: var(--band); } .bad { color: var(--bad); }
.none { color: var(--dim); } .kept { color: var(--c4); }
.verdict { font-weight: 600; } .verdict::before { content: attr(data-sign) "\\00a0"; }
.failed { background: var(--failback); border: 2px solid var(--fail); border-radius: 8px; padding: .8rem 1rem;
          margin: .8rem 0; }
.failed strong { color: var(--fail); }
.figures { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 27rem), 1fr)); gap: 1.2rem 1.6rem;
           margin: 1.1rem 0; }
figure { margin: 0; min-width: 0; max-width: 40rem; } figcaption { color: var(--dim); font-size: .9rem; }
figcaption b { color: var(--text); } .figtitle { font-weight: 600; font-size: .95rem; margin: 0 0 .2rem; }
svg { display: block; overflow: visible; width: 100%; height: auto; color: var(--text); font-family: inherit; }
svg text { fill: var(--dim); font-size: 12px; } svg text.label { fill: var(--text); font-size: 12.5px; }
svg text.marked { fill: var(--paper); font-size: 12px; font-weight: 600; paint-order: stroke; stroke: var(--back);
                  stroke-width: 4px; stroke-linejoin: round; }
svg path { fill: none; stroke: currentColor; stroke-linejoin: round; stroke-linecap: round; }
svg .grid { stroke: var(--grid); } svg .axis { stroke: var(--dim); }
svg .line, svg .steps { stroke-width: 1.7; } svg .dashed { stroke-width: 1.7; stroke-dasharray: 5 4; }
svg .thin { stroke-width: .8; opacity: .55; } svg .points { stroke-width: 4.5; opacity: .85; }
svg .bar { stroke-width: 9; opacity: .35; stroke-linecap: butt; }
svg .mark { stroke: var(--paper); stroke-width: 1.3; stroke-dasharray: 2 3; }
svg .mark.point { stroke-dasharray: none; stroke-width: 1.6; }
.c0 { stroke: var(--c0); --own: var(--c0); } .c1 { stroke: var(--c1); --own: var(--c1); }
.c2 { stroke: var(--c2); --own: var(--c2); } .c3 { stroke: var(--c3); --own: var(--c3); }
.c4 { stroke: var(--c4); --own: var(--c4); } .c5 { stroke: var(--c5); --own: var(--c5); }
svg .c0 { stroke: var(--c0); } svg .c1 { stroke: var(--c1); } svg .c2 { stroke: var(--c2); } svg .c3 { stroke: var(--c3); }
svg .c4 { stroke: var(--c4); } svg .c5 { stroke: var(--c5); }
.legend { display: flex; flex-wrap: wrap; gap: .1rem 1rem; font-size: .85rem; margin: .1rem 0 .3rem; }
.sample { display: inline-block; width: 1.4rem; height: 0; margin-right: .4rem; vertical-align: .25em;
          border-top: 2.5px solid var(--own); }
.sample.dashed { border-top-style: dashed; } .sample.thin { border-top-width: 1px; opacity: .7; }
.sample.points { width: .5rem; height: .5rem; border: 0; border-radius: 50%; background: var(--own); vertical-align: 0; }
.sample.bar { border-top-width: .6rem; opacity: .4; vertical-align: 0; }
.sample.mark { border-top: 2px dotted var(--paper); }
.sample.mark.point { width: .5rem; height: .5rem; border: 1.5px solid var(--paper); transform: rotate(45deg);
                     vertical-align: 0; }
table { border-collapse: collapse; width: 100%; font-size: .9rem; margin: .8rem 0; }
th, td { padding: .45rem .8rem .45rem 0; text-align: left; vertical-align: top; border-bottom: 1px solid var(--line);
         overflow-wrap: break-word; }
th { font-size: .8rem; color: var(--dim); font-weight: 600; } td { font-variant-numeric: tabular-nums; }
td.item { font-weight: 600; } td.item small { display: block; font-weight: 400; color: var(--dim); }
table { table-layout: fixed; } th:nth-child(1) { width: 14%; } th:nth-child(2) { width: 15%; } th:nth-child(3) { width: 9%; }
th:nth-child(4) { width: 12%; } th:nth-child(5) { width: 12%; } th:nth-child(6) { width: 13%; }
td.cell { padding-right: 1rem; } td.value { color: var(--dim); } td.tolerance { color: var(--dim); font-size: .82rem; }
tbody tr:not(:first-child) td.cell, tbody tr:not(:last-child) td.cell { border-bottom: 0; padding-bottom: 0; }
tbody tr:not(:first-child) td.cell { padding-top: .1rem; }
tbody tr:last-child td.cell { border-bottom: 1px solid var(--line); padding-bottom: .45rem; }
tbody tr:not(:last-child) td[rowspan] { border-bottom: 1px solid var(--line); }
td.remark p { margin: 0 0 .35rem; } .reason::before { content: "Why not: "; font-weight: 600; }
details { margin: .6rem 0; } summary { cursor: pointer; color: var(--dim); }
.logs { padding-left: 1.1rem; columns: 24rem; } .logs li { margin: .2rem 0; break-inside: avoid; }
@media (min-width: 60rem) {
  .figures > figure:only-child { display: grid; grid-template-columns: 40rem 1fr; column-gap: 2rem; max-width: none; }
  figure:only-child svg { grid-row: 2 / 5; grid-column: 1; } figure:only-child > :not(svg, .figtitle) { grid-column: 2; }
  figure:only-child .figtitle { grid-column: 1 / -1; } figure:only-child .legend { align-content: start; }
}
@media (max-width: 52rem) {
  td.alone.computed { grid-column: 1 / -1; } td.alone.paper, td.alone.tolerance { display: none !important; }
  table { display: block; } thead { display: none; } tr { display: contents; }
  tbody { display: grid; grid-template-columns: repeat(3, minmax(0, 1fr)); gap: .1rem .7rem; border: 1px solid var(--line);
          border-radius: 8px; padding: .6rem .8rem; margin: .7rem 0; }
  tbody tr td, tbody tr td.cell, tbody tr:last-child td.cell, tbody tr:not(:last-child) td[rowspan] {
    display: block; border: 0; padding: 0; width: auto; max-width: none; min-width: 0; overflow-wrap: anywhere; }
  td.item, td.verdict, td.remark, td.value { grid-column: 1 / -1; } td:empty { display: none !important; }
  td.item { order: 0; } td.verdict { order: 1; } td.cell { order: 2; } td.remark { order: 3; }
  td.value { font-size: .85rem; } tbody td.value, tbody td.remark { margin-top: .35rem; }
  td.cell:not(.value)::before { content: attr(data-label); display: block; font-size: .72rem; line-height: 1.2;
    color: var(--dim); }
}
@media (max-width: 36rem) { svg text, svg text.label, svg text.marked { font-size: 14.5px; } }
@media print {
  body { max-width: none; padding: 0; font-size: 10pt; } section { break-inside: auto; } figure, tr { break-inside: avoid; }
  .figures { grid-template-columns: 1fr 1fr; } a { color: inherit; text-decoration: none; } nav { display: none; }
}
"""
