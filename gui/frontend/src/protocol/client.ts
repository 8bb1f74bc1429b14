/** Talks to the server: questions over HTTP, news over one WebSocket that comes back by itself. */
import type {
  BreakpointsWish,
  CatalogView,
  CloudView,
  CommentView,
  ComponentForm,
  Control,
  ConversionView,
  ConvertWish,
  DeskView,
  DiskWish,
  DocumentView,
  Done,
  EditWish,
  ExpressionView,
  ExpressionWish,
  FormsView,
  GeometryView,
  ImportView,
  ImportWish,
  InterfaceView,
  InterfaceWish,
  Introduce,
  LeaseWish,
  LiveMessage,
  LiveMessages,
  MeasureWish,
  MessageDeed,
  MotionView,
  NamesView,
  NewTask,
  PartsView,
  PinWish,
  PlacesView,
  ProbeView,
  ProbeWish,
  ProblemsView,
  ProjectView,
  PutWish,
  ReceivedView,
  ReceiveWish,
  RecordWish,
  RobotParts,
  RunRecord,
  RunView,
  SaveWish,
  Selection,
  ServerFrame,
  SessionView,
  SetupChange,
  SetupList,
  SetupSave,
  SetupText,
  SetupView,
  StartRun,
  StepWish,
  Subscribe,
  TextWish,
  TopicsView,
  Trouble,
  TryView,
  TryWish,
  ValueView,
} from "./generated";

/** How this page is called among the viewers; a reload keeps the name, another tab has its own. */
export const PAGE = ownName();

function ownName(): string {
  const kept = sessionStorage.getItem("grip-page");
  const name = kept ?? Array.from(crypto.getRandomValues(new Uint8Array(8)), (byte) => byte.toString(16).padStart(2, "0")).join("");
  sessionStorage.setItem("grip-page", name);
  return name;
}

/** A request that the server refused; `kind` says what the page can do about it. */
export class RefusedError extends Error {
  constructor(
    message: string,
    readonly kind: string,
  ) {
    super(message);
  }
}

async function ask<T>(path: string, body?: unknown): Promise<T> {
  const init: RequestInit =
    body === undefined
      ? {}
      : { method: "POST", headers: { "content-type": "application/json" }, body: JSON.stringify(body) };
  const answer = await fetch(`/api/${path}`, init);
  if (!answer.ok) {
    const trouble = (await answer.json().catch(() => null)) as Trouble | null;
    throw new RefusedError(trouble?.detail ?? `the server answered ${answer.status}`, trouble?.kind ?? "");
  }
  return (await answer.json()) as T;
}

export const server = {
  project: () => ask<ProjectView>("project"),
  catalog: () => ask<CatalogView>("catalog"),
  document: (path: string, since = 0) => ask<DocumentView>(`document?path=${encodeURIComponent(path)}&since=${since}`),
  problems: (path: string) => ask<ProblemsView>(`document/problems?path=${encodeURIComponent(path)}`),
  forms: (path: string) => ask<FormsView>(`document/forms?path=${encodeURIComponent(path)}`),
  places: (path: string) => ask<PlacesView>(`document/places?path=${encodeURIComponent(path)}`),
  comment: (path: string, node: string) => ask<CommentView>(`document/comment?path=${encodeURIComponent(path)}&node=${encodeURIComponent(node)}`),
  parts: (path: string, nodes: readonly string[]) =>
    ask<PartsView>(`document/parts?path=${encodeURIComponent(path)}${nodes.map((node) => `&node=${encodeURIComponent(node)}`).join("")}`),
  conversion: (path: string, node: string, form: ConvertWish["form"], approximate: boolean) =>
    ask<ConversionView>(`document/conversion?path=${encodeURIComponent(path)}&node=${encodeURIComponent(node)}&form=${form}&approximate=${approximate}`),
  convert: (wish: ConvertWish, since: number) => ask<DocumentView>(`document/convert?since=${since}`, wish),
  edit: (wish: EditWish, since: number) => ask<DocumentView>(`document/edit?since=${since}`, wish),
  text: (wish: TextWish, since: number) => ask<DocumentView>(`document/text?since=${since}`, wish),
  step: (wish: StepWish, since: number) => ask<DocumentView>(`document/step?since=${since}`, wish),
  pin: (wish: PinWish, since: number) => ask<DocumentView>(`document/pin?since=${since}`, wish),
  save: (wish: SaveWish, since: number) => ask<DocumentView>(`document/save?since=${since}`, wish),
  disk: (wish: DiskWish, since: number) => ask<DocumentView>(`document/disk?since=${since}`, wish),
  newTask: (wish: NewTask) => ask<DocumentView>("document/new", wish),
  expression: (wish: ExpressionWish) => ask<ExpressionView>("document/expression", wish),
  runs: () => ask<RunRecord[]>("runs"),
  run: (id: string) => ask<RunView>(`runs/${encodeURIComponent(id)}`),
  start: (wish: StartRun) => ask<SessionView>("session", wish),
  control: (wish: Control) => ask<SessionView>("session/control", wish),
  breakpoints: (wish: BreakpointsWish) => ask<DeskView>("breakpoints", wish),
  lease: (wish: LeaseWish) => ask<DeskView>("lease", wish),
  names: () => ask<NamesView>("setup/names"),
  setupFiles: () => ask<SetupList>("setup/files"),
  setupFile: (path: string) => ask<SetupView>(`setup/file?path=${encodeURIComponent(path)}`),
  setupCheck: (wish: SetupText) => ask<SetupView>("setup/check", wish),
  setupChange: (wish: SetupChange) => ask<SetupView>("setup/change", wish),
  setupSave: (wish: SetupSave) => ask<SetupView>("setup/save", wish),
  setupProbe: (wish: ProbeWish) => ask<ProbeView>("setup/probe", wish),
  setupInterface: (wish: InterfaceWish) => ask<InterfaceView>("setup/interface", wish),
  setupImport: (wish: ImportWish) => ask<ImportView>("setup/import", wish),
  record: (wish: RecordWish) => ask<SetupView>("setup/record", wish),
  topics: () => ask<TopicsView>("live/topics"),
  receive: (wish: ReceiveWish) => ask<ReceivedView>("live/receive", wish),
  liveMessages: () => ask<LiveMessages>("live/messages"),
  liveMessage: (store: string, name: string) => ask<LiveMessage>(`live/message?store=${encodeURIComponent(store)}&name=${encodeURIComponent(name)}`),
  putMessage: (wish: PutWish) => ask<Done>("live/put", wish),
  messageDeed: (wish: MessageDeed) => ask<Done>("live/messages", wish),
  robotParts: () => ask<RobotParts>("live/robot"),
  measure: (wish: MeasureWish) => ask<Done>("live/measure", wish),
  componentForm: (path: string) => ask<ComponentForm>(`live/component?path=${encodeURIComponent(path)}`),
  callComponent: (wish: TryWish) => ask<TryView>("live/component", wish),
  geometry: () => ask<GeometryView>("live/geometry"),
  motion: (run: string, after: number) => ask<MotionView>(`live/motion?run=${encodeURIComponent(run)}&after=${after}`),
  cloud: (run: string, seq: number) => ask<CloudView>(`runs/${encodeURIComponent(run)}/values/${seq}/cloud`),
  value: (run: string, seq: number) => ask<ValueView>(`runs/${encodeURIComponent(run)}/values/${seq}`),
};

const LONGEST_PAUSE = 5000;

export interface SocketListener {
  frame(frame: ServerFrame): void;
  connected(yes: boolean): void;
  /** What to subscribe to, asked after every (re)connection. */
  wish(): Subscribe | null;
  /** What this page says of itself, after every (re)connection and whenever it changes. */
  introduction(): Introduce;
  /** What is selected on this page, after every (re)connection. */
  selection(): Selection;
}

/** The socket; it reconnects with growing pauses until `close`. */
export class Socket {
  private socket: WebSocket | null = null;
  private pause = 250;
  private closed = false;
  private timer: ReturnType<typeof setTimeout> | undefined;

  constructor(private readonly listener: SocketListener) {
    this.open();
  }

  subscribe(): void {
    const wish = this.listener.wish();
    if (wish && this.socket?.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(wish));
  }

  introduce(): void {
    if (this.socket?.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(this.listener.introduction()));
  }

  select(selection: Selection): void {
    if (this.socket?.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(selection));
  }

  close(): void {
    this.closed = true;
    clearTimeout(this.timer);
    this.socket?.close();
  }

  private open(): void {
    const scheme = location.protocol === "https:" ? "wss" : "ws";
    const socket = new WebSocket(`${scheme}://${location.host}/api/socket?page=${PAGE}`);
    this.socket = socket;
    socket.onopen = () => {
      this.pause = 250;
      this.listener.connected(true);
      this.introduce();
      this.select(this.listener.selection());
      this.subscribe();
    };
    socket.onmessage = (message) => this.listener.frame(JSON.parse(String(message.data)) as ServerFrame);
    socket.onclose = () => {
      if (this.closed) return;
      this.listener.connected(false);
      this.timer = setTimeout(() => this.open(), this.pause);
      this.pause = Math.min(this.pause * 2, LONGEST_PAUSE);
    };
  }
}
