"use strict";
(async () => {
  const byId = (id) => document.getElementById(id);
  const facts = JSON.parse(byId("facts").textContent);
  const GLYPHS = { running: "▶", success: "✓", ended: "■", failure: "✗", error: "‼", interrupted: "⊘" };
  const seconds = (t) => `${t.toFixed(t < 100 ? 3 : 1)} s`;

  // --- events: columns, deflated ---

  async function inflated(text) {
    const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
    return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate-raw"))).json();
  }
  const { kinds } = facts.events;
  const [[kindOf, steps], said] = await Promise.all([facts.events.columns, facts.events.texts].map(inflated));
  const count = kindOf.length;
  let micros = 0;
  const times = steps.map((step) => (micros += step) / 1e6);
  const eventAt = (i) => {
    const [path, event, outcome, code, meaning] = kinds[kindOf[i]];
    return { path, event, outcome, code, meaning, data: said[i] ?? {}, t: times[i] };
  };

  // --- what a moment is like; the same rules as on GRIP's page ---

  const paths = [...new Set([...Object.keys(facts.nodes), ...kinds.map((kind) => kind[0])])];
  const below = new Map(paths.map((path) => [path, []]));
  for (const path of paths) {
    if (path !== "/") below.get("/")?.push(path);
    for (let at = path.lastIndexOf("/"); at > 0; at = path.lastIndexOf("/", at - 1)) below.get(path.slice(0, at))?.push(path);
  }
  // What an end means is in the journal; those of earlier versions don't say it of a task's own outcomes, which stand in the task.
  const phaseOf = ({ path, outcome, meaning }) => meaning ?? facts.nodes[path]?.outcomes[outcome] ?? "ended";
  function apply(state, i) {
    const { path, event, outcome, code, meaning, data, t } = eventAt(i);
    const before = state.nodes.get(path) ?? { activations: 0 };
    if (event === "enter") {
      for (const other of below.get(path) ?? []) state.nodes.delete(other);
      state.nodes.set(path, { phase: "running", since: t, activations: before.activations + 1 });
    } else if (event === "exit") {
      const how = { phase: phaseOf({ path, outcome, meaning }), since: t, outcome, code, message: data.message };
      state.nodes.set(path, { ...how, activations: before.activations });
    } else if (event === "interrupted") state.nodes.set(path, { phase: event, since: t, activations: before.activations });
    else if (event === "message") state.nodes.set(path, { ...before, message: data.text });
    else if (event === "error") state.nodes.set(path, { ...before, phase: "error", since: t, message: `${data.type}: ${data.message}` });
    else if (event === "write") state.variables.set(data.variable ?? "?", { preview: data.preview ?? "…", type: data.type ?? "", by: path });
    else if (event === "state") state.run = data.state;
    else if (event === "run_started") state.run = "running";
    else if (event === "run_resumed") {
      state.run = "running";
      for (const [open, node] of state.nodes) if (node.phase === "error") state.nodes.set(open, { ...node, phase: "running", message: "" });
    }
    else if (event === "run_ended") state.run = outcome ? `${data.status}: ${outcome}` : data.status;
  }
  const EVERY = 2000;
  const frames = [{ nodes: new Map(), variables: new Map(), run: "before the start" }];
  const copied = (state) => ({ nodes: new Map(state.nodes), variables: new Map(state.variables), run: state.run });
  let current = copied(frames[0]);
  let shown = 0;
  function momentAt(n) {
    const frame = Math.min(Math.floor(n / EVERY), frames.length - 1);
    if (n < shown || frame * EVERY > shown) {
      current = copied(frames[frame]);
      shown = frame * EVERY;
    }
    for (; shown < n; shown++) {
      if (shown % EVERY === 0 && shown / EVERY === frames.length) frames.push(copied(current));
      apply(current, shown);
    }
    return current;
  }

  // --- drawings ---

  const drawn = new Map();
  const SVG = "http://www.w3.org/2000/svg";
  for (const group of document.querySelectorAll("[data-path]")) {
    const path = group.dataset.path;
    const box = group.querySelector("rect");
    const badge = document.createElementNS(SVG, "text");
    badge.setAttribute("class", "badge");
    badge.setAttribute("x", Number(box.getAttribute("x")) + Number(box.getAttribute("width")) - 5);
    badge.setAttribute("y", Number(box.getAttribute("y")) + 7);
    group.append(badge);
    drawn.set(path, [...(drawn.get(path) ?? []), { group, badge }]);
    group.addEventListener("click", (event) => {
      event.stopPropagation();
      choose(path);
    });
  }
  const lit = new Map();
  function light(state) {
    for (const [path, marks] of drawn) {
      const phase = state.nodes.get(path)?.phase ?? "";
      if (lit.get(path) === phase) continue;
      lit.set(path, phase);
      for (const { group, badge } of marks) {
        group.dataset.phase = phase;
        badge.textContent = GLYPHS[phase] ?? "";
      }
      const option = options.get(path);
      if (option) option.textContent = `${option.dataset.name}${phase ? `  ${GLYPHS[phase]} ${phase}` : ""}`;
    }
  }

  // --- the side ---

  const options = new Map();
  for (const path of Object.keys(facts.nodes)) {
    const option = new Option("", path);
    const depth = path === "/" ? 0 : path.split("/").length;
    option.dataset.name = "\u00a0\u00a0".repeat(depth) + (path === "/" ? facts.run.task_name : path.split("/").at(-1));
    option.textContent = option.dataset.name;
    options.set(path, option);
    byId("nodes").append(option);
  }
  let chosen = "/";
  function choose(path) {
    chosen = path;
    byId("nodes").value = path;
    for (const [other, marks] of drawn) for (const { group } of marks) group.toggleAttribute("data-chosen", other === path);
    sides();
  }
  const element = (tag, text, name) => Object.assign(document.createElement(tag), { textContent: text, className: name ?? "" });
  function sides() {
    const node = facts.nodes[chosen];
    const state = current.nodes.get(chosen);
    const list = document.createElement("dl");
    const row = (name, text, style) => text && list.append(element("dt", name), element("dd", text, style));
    const pairs = (of) => Object.entries(of).map(([key, value]) => `${key}: ${typeof value === "string" ? value : JSON.stringify(value)}`).join(", ");
    const said = state?.outcome ? `${state.outcome}${state.code ? `.${state.code}` : ""}` : (state?.phase ?? "not begun");
    row("node", chosen);
    row("is", node.what);
    row("doc", node.doc);
    row("parameters", pairs(node.with));
    row("reads", pairs(node.in));
    row("writes", pairs(node.out));
    row("now", `${GLYPHS[state?.phase] ?? ""} ${said}`.trim(), state?.phase);
    row("says", state?.message);
    row("begun", state ? (state.activations === 1 ? "once" : `${state.activations} times`) : "");
    byId("node").replaceChildren(list);
    const rows = [...current.variables].sort().map(([name, { preview, type, by }]) => {
      const line = document.createElement("tr");
      line.title = `${type}, written by ${by}`;
      line.append(element("td", name), element("td", preview));
      return line;
    });
    byId("variables").replaceChildren(...(rows.length ? rows : [element("caption", "Nothing was written yet.")]));
  }
  function eventText(i) {
    const { path, event, outcome, code, meaning, data, t } = eventAt(i);
    const phase = event === "enter" ? "running" : event === "exit" ? phaseOf({ path, outcome, meaning }) : event;
    const more = { exit: `${outcome}${code ? `.${code}` : ""}${data.message ? ` (${data.message})` : ""}`, message: data.text,
      write: `${data.variable ?? ""} = ${data.preview ?? "…"}`, state: data.state, run_ended: data.status,
      error: `${data.type}: ${data.message}`, enter: "begins", interrupted: "is halted",
      damaged: data.message, run_resumed: "the run goes on in another process", went_on: { resume: "goes on", restart: "is started again" }[data.how] ?? "has ended as somebody said",
      kept: `its ${data.part} is kept for going on`, zombie: `left behind in ${data.where}` }[event];
    return `${i + 1}  ${seconds(t)}  ${GLYPHS[phase] ?? "·"} ${path} ${more ?? event.replace("_", " ")}`;
  }
  const AROUND = 60;
  function list() {
    const from = Math.max(0, at - AROUND);
    const rows = [];
    for (let i = from; i < Math.min(count, at + AROUND); i++) {
      const row = document.createElement("li");
      const button = Object.assign(element("button", eventText(i)), { type: "button", tabIndex: -1, onclick: () => go(i + 1) });
      if (i === at - 1) button.setAttribute("aria-current", "true");
      row.append(button);
      rows.push(row);
    }
    byId("events").replaceChildren(...rows);
    const here = byId("events").querySelector("[aria-current]");
    if (here) byId("events").scrollTop = here.offsetTop - byId("events").offsetTop - 140;
  }

  // --- the time line ---

  const end = Math.max(count ? times[count - 1] : 0, 1e-6);
  const begin = count ? times[0] : 0;
  const spans = [];
  {
    const leaves = new Set(paths.filter((path) => path !== "/" && !below.get(path).length));
    const open = new Map();
    const lanes = [];
    for (let i = 0; i < count; i++) {
      const { path, event, outcome, meaning, t } = eventAt(i);
      if (!leaves.has(path)) continue;
      if (event === "enter") {
        let lane = lanes.findIndex((busy) => !busy);
        if (lane < 0) lane = lanes.push(false) - 1;
        lanes[lane] = true;
        open.set(path, { path, from: t, to: end, phase: "running", lane });
      } else if (open.has(path) && (event === "exit" || event === "interrupted")) {
        const span = open.get(path);
        open.delete(path);
        lanes[span.lane] = false;
        spans.push({ ...span, to: t, phase: event === "exit" ? phaseOf({ path, outcome, meaning }) : event });
      }
    }
    spans.push(...open.values());
  }
  const lanes = Math.max(2, ...spans.map((span) => span.lane + 1));
  let picture = null;
  function paint() {
    const canvas = byId("spans");
    const scale = window.devicePixelRatio || 1;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    const style = getComputedStyle(document.documentElement);
    const colour = (name) => style.getPropertyValue(`--${name}`).trim();
    const x = (t) => ((t - begin) / (end - begin || 1)) * width;
    const context = canvas.getContext("2d");
    const key = `${width} ${scale} ${document.documentElement.dataset.theme}`;
    if (picture?.key !== key) {
      const layer = Object.assign(document.createElement("canvas"), { width: width * scale, height: height * scale });
      const ink = layer.getContext("2d");
      ink.scale(scale, scale);
      ink.font = "11px sans-serif";
      for (const span of spans) {
        const [left, top, tall] = [x(span.from), (span.lane / lanes) * height, height / lanes - 2];
        const wide = Math.max(1, x(span.to) - left - 0.5);
        ink.fillStyle = colour(span.phase === "ended" ? "interrupted" : span.phase === "error" ? "failure" : span.phase);
        ink.globalAlpha = 0.28;
        ink.fillRect(left, top, wide, tall);
        ink.globalAlpha = 1;
        ink.fillRect(left, top, Math.min(2, wide), tall);
        const words = `${GLYPHS[span.phase] ?? ""} ${span.path.split("/").at(-1)}`;
        if (wide > 24 && tall > 10) {
          ink.save();
          ink.beginPath();
          ink.rect(left, top, wide, tall);
          ink.clip();
          ink.fillStyle = colour("ink");
          ink.fillText(words, left + 5, top + Math.min(tall, 18) - 5);
          ink.restore();
        }
      }
      picture = { key, layer };
    }
    canvas.width = width * scale;
    canvas.height = height * scale;
    context.drawImage(picture.layer, 0, 0);
    context.fillStyle = colour("focus");
    context.fillRect((at ? x(times[at - 1]) : 0) * scale - scale, 0, 2 * scale, height * scale);
  }
  function countAt(t) {
    let [low, high] = [0, count];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (times[middle] <= t) low = middle + 1;
      else high = middle;
    }
    return low;
  }

  // --- going through it ---

  let at = 0;
  let waiting = false;
  function go(n) {
    at = Math.max(0, Math.min(count, n));
    byId("moment").value = at;
    if (!waiting) {
      waiting = true;
      requestAnimationFrame(draw);
    }
  }
  function draw() {
    waiting = false;
    const state = momentAt(at);
    light(state);
    sides();
    list();
    paint();
    const words = `${at ? seconds(times[at - 1]) : "0 s"} of ${seconds(count ? times[count - 1] : 0)}, event ${at} of ${count}, ${state.run}`;
    byId("words").textContent = words;
    byId("moment").setAttribute("aria-valuetext", at ? `${words}: ${eventText(at - 1)}` : words);
    if (byId("follow").checked && at && !byId("fit").checked) {
      const view = document.querySelector(".view:not([hidden])");
      const mark = drawn.get(eventAt(at - 1).path)?.find(({ group }) => view.contains(group));
      mark?.group.querySelector("rect").scrollIntoView({ block: "nearest", inline: "nearest" });
    }
  }
  let playing = 0;
  function play(on) {
    cancelAnimationFrame(playing);
    playing = 0;
    byId("play").textContent = on ? "⏸" : "▶";
    byId("play").setAttribute("aria-label", on ? "Pause (space)" : "Play (space)");
    if (!on) return;
    if (at >= count) go(0);
    let t = at ? times[at - 1] : begin;
    let then = performance.now();
    const step = (now) => {
      t += ((now - then) / 1000) * Number(byId("speed").value);
      then = now;
      const n = countAt(t);
      if (n !== at) go(n);
      if (n >= count) play(false);
      else playing = requestAnimationFrame(step);
    };
    playing = requestAnimationFrame(step);
  }
  function show(view) {
    for (const name of ["tree", "flow"]) {
      byId(name).hidden = name !== view;
      byId(`tab-${name}`).setAttribute("aria-selected", String(name === view));
    }
  }
  function fit() {
    for (const view of document.querySelectorAll(".view")) view.classList.toggle("fit", byId("fit").checked);
  }
  function theme(name) {
    document.documentElement.dataset.theme = name;
    picture = null;
    paint();
  }
  const dark = matchMedia("(prefers-color-scheme: dark)");
  const other = () => theme(document.documentElement.dataset.theme === "dark" ? "light" : "dark");

  byId("moment").max = count;
  byId("moment").addEventListener("input", (event) => go(Number(event.target.value)));
  byId("first").onclick = () => go(0);
  byId("back").onclick = () => go(at - 1);
  byId("forth").onclick = () => go(at + 1);
  byId("last").onclick = () => go(count);
  byId("play").onclick = () => play(!playing);
  byId("tab-tree").onclick = () => show("tree");
  byId("tab-flow").onclick = () => show("flow");
  byId("theme").onclick = other;
  byId("fit").onchange = fit;
  byId("nodes").onchange = (event) => choose(event.target.value);
  const scrub = (event) => {
    const box = byId("spans").getBoundingClientRect();
    go(countAt(begin + ((event.clientX - box.left) / box.width) * (end - begin)));
  };
  byId("spans").addEventListener("pointerdown", scrub);
  byId("spans").addEventListener("pointermove", (event) => event.buttons === 1 && scrub(event));
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const field = event.target.closest("select, pre, .view");
    const button = event.target.closest("button, input[type=checkbox], summary");
    if (event.key === "t" || event.key === "T") return field?.tagName === "SELECT" ? undefined : other();
    if (field || (button && event.key === " ")) return;
    const to = { ArrowLeft: at - 1, ArrowRight: at + 1, PageUp: at - 10, PageDown: at + 10, Home: 0, End: count }[event.key];
    if (event.key === " ") play(!playing);
    else if (to !== undefined) go(to);
    else return;
    event.preventDefault();
  });
  addEventListener("resize", () => paint());
  dark.addEventListener("change", () => theme(dark.matches ? "dark" : "light"));

  const { run } = facts;
  byId("name").textContent = run.task_name;
  const began = new Date(run.started * 1000).toLocaleString();
  const form = run.target === "sm" ? "state machine" : "behaviour tree";
  const how = [run.outcome && run.outcome !== run.status ? `${run.status}: ${run.outcome}` : run.status, form, began, `run ${run.id}`];
  byId("how").textContent = how.filter(Boolean).join(" · ");
  byId("doc").textContent = facts.doc;
  byId("foot").textContent = `${facts.file}; written by GRIP ${facts.grip}. Space plays, arrows step, Home and End go to the ends, T changes light and dark.`;
  if (facts.left_out) Object.assign(byId("left-out"), { hidden: false, textContent: `Left out, to keep this file small: ${facts.left_out}.` });
  fit();
  document.documentElement.dataset.theme = dark.matches ? "dark" : "light";
  choose("/");
  go(count);
  document.documentElement.dataset.ready = "yes";
})();
