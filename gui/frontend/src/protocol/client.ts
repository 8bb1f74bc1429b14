/** Talks to the server: questions over HTTP, news over one WebSocket that comes back by itself. */
import type {
  BeginRequest,
  BeginView,
  BreakpointsRequest,
  CatalogView,
  CloudView,
  CommentView,
  ComponentForm,
  Control,
  ConversionView,
  SharedState,
  OfDocument,
  DocumentView,
  Done,
  EditRequest,
  ExpressionRequest,
  FolderView,
  FormsView,
  GeometryView,
  ImportView,
  ImportRequest,
  InterfaceView,
  InterfaceRequest,
  Introduce,
  ControlRequest,
  LiveMessage,
  LiveMessages,
  MeasureRequest,
  MessageRequest,
  MotionView,
  NewTask,
  Part,
  PinRequest,
  PlacesView,
  CommandResult,
  CommandRequest,
  ProblemsView,
  ProjectView,
  PutRequest,
  ReceivedView,
  ReceiveRequest,
  RecordRequest,
  RunRecord,
  RunView,
  SaveRequest,
  Selection,
  ServerFrame,
  SessionView,
  SetupChange,
  SetupEntry,
  SetupSave,
  SetupText,
  SetupView,
  StartRun,
  StudySpan,
  StepRequest,
  Subscribe,
  TextRequest,
  TopicsView,
  ErrorBody,
  TryView,
  TryRequest,
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

/** What a ready-made arm with a hand is made of. */
export interface Pair {
  readonly arm: string;
  readonly hand: string;
  readonly mount: { readonly link: string };
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

/** The server doesn't answer at all. */
export class GoneError extends Error {
  constructor() {
    super("The server doesn't answer.");
  }
}

async function answered(path: string, body?: unknown): Promise<Response> {
  const init: RequestInit =
    body === undefined
      ? {}
      : { method: "POST", headers: { "content-type": "application/json" }, body: JSON.stringify(body) };
  const answer = await fetch(`/api/${path}`, init).catch(() => {
    throw new GoneError();
  });
  if (!answer.ok) {
    const error = (await answer.json().catch(() => null)) as ErrorBody | null;
    throw new RefusedError(error?.detail ?? `the server answered ${answer.status}`, error?.kind ?? "");
  }
  return answer;
}

async function ask<T>(path: string, body?: unknown): Promise<T> {
  return (await (await answered(path, body)).json()) as T;
}

/** The page's own policy shows pictures of `data:`, not of `blob:`. */
function asAddress(picture: Blob): Promise<string> {
  return new Promise((resolve, reject) => {
    const reader = new FileReader();
    reader.onload = () => resolve(String(reader.result));
    reader.onerror = () => reject(reader.error ?? new Error("the picture can't be read"));
    reader.readAsDataURL(picture);
  });
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
    ask<Part[]>(`document/parts?path=${encodeURIComponent(path)}${nodes.map((node) => `&node=${encodeURIComponent(node)}`).join("")}`),
  conversion: (path: string, node: string, form: "tree" | "machine") =>
    ask<ConversionView>(`document/conversion?path=${encodeURIComponent(path)}&node=${encodeURIComponent(node)}&form=${form}`),
  edit: (request: EditRequest, since: number) => ask<DocumentView>(`document/edit?since=${since}`, request),
  text: (request: TextRequest, since: number) => ask<DocumentView>(`document/text?since=${since}`, request),
  step: (request: StepRequest, since: number) => ask<DocumentView>(`document/step?since=${since}`, request),
  pin: (request: PinRequest, since: number) => ask<DocumentView>(`document/pin?since=${since}`, request),
  save: (request: SaveRequest, since: number) => ask<DocumentView>(`document/save?since=${since}`, request),
  disk: (request: OfDocument, since: number) => ask<DocumentView>(`document/disk?since=${since}`, request),
  study: (span: StudySpan) => ask<boolean>("study", span),
  newTask: (request: NewTask) => ask<DocumentView>("document/new", request),
  expression: (request: ExpressionRequest) => ask<string[]>("document/expression", request),
  runs: () => ask<RunRecord[]>("runs"),
  run: (id: string) => ask<RunView>(`runs/${encodeURIComponent(id)}`),
  start: (request: StartRun) => ask<SessionView>("session", request),
  control: (request: Control) => ask<SessionView>("session/control", request),
  breakpoints: (request: BreakpointsRequest) => ask<SharedState>("breakpoints", request),
  lease: (request: ControlRequest) => ask<SharedState>("lease", request),
  names: () => ask<Record<string, string[]>>("setup/names"),
  setupFiles: () => ask<SetupEntry[]>("setup/files"),
  setupFile: (path: string) => ask<SetupView>(`setup/file?path=${encodeURIComponent(path)}`),
  setupCheck: (request: SetupText) => ask<SetupView>("setup/check", request),
  setupChange: (request: SetupChange) => ask<SetupView>("setup/change", request),
  setupSave: (request: SetupSave) => ask<SetupView>("setup/save", request),
  setupProbe: (request: CommandRequest) => ask<CommandResult>("setup/probe", request),
  setupInterface: (request: InterfaceRequest) => ask<InterfaceView>("setup/interface", request),
  setupImport: (request: ImportRequest) => ask<ImportView>("setup/import", request),
  robots: () => ask<Record<string, string>>("setup/robots"),
  pairs: () => ask<Record<string, Pair>>("setup/pairs"),
  examples: () => ask<Record<string, string>>("setup/examples"),
  browse: (at: string) => ask<FolderView>(`setup/browse?at=${encodeURIComponent(at)}`),
  begin: (request: BeginRequest) => ask<BeginView>("setup/begin", request),
  picture: async (world: string, camera: string) => asAddress(await (await answered(`setup/picture?world=${encodeURIComponent(world)}&camera=${encodeURIComponent(camera)}`)).blob()),
  record: (request: RecordRequest) => ask<SetupView>("setup/record", request),
  topics: () => ask<TopicsView>("live/topics"),
  receive: (request: ReceiveRequest) => ask<ReceivedView>("live/receive", request),
  liveMessages: () => ask<LiveMessages>("live/messages"),
  liveMessage: (store: string, name: string) => ask<LiveMessage>(`live/message?store=${encodeURIComponent(store)}&name=${encodeURIComponent(name)}`),
  putMessage: (request: PutRequest) => ask<Done>("live/put", request),
  messageDeed: (request: MessageRequest) => ask<Done>("live/messages", request),
  measure: (request: MeasureRequest) => ask<Done>("live/measure", request),
  componentForm: (path: string) => ask<ComponentForm>(`live/component?path=${encodeURIComponent(path)}`),
  callComponent: (request: TryRequest) => ask<TryView>("live/component", request),
  geometry: (robot = "") => ask<GeometryView>(`live/geometry?robot=${encodeURIComponent(robot)}`),
  motion: (run: string, after: number) => ask<MotionView>(`live/motion?run=${encodeURIComponent(run)}&after=${after}`),
  cloud: (run: string, seq: number) => ask<CloudView>(`runs/${encodeURIComponent(run)}/values/${seq}/cloud`),
  value: (run: string, seq: number) => ask<ValueView>(`runs/${encodeURIComponent(run)}/values/${seq}`),
};

const LONGEST_PAUSE = 5000;

export interface SocketListener {
  frame(frame: ServerFrame): void;
  /** Told of every connection and its end; `stranger` where a server answers that doesn't know this page's token. */
  connected(yes: boolean, stranger: boolean): void;
  /** What to subscribe to, asked after every (re)connection. */
  request(): Subscribe | null;
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
    const request = this.listener.request();
    if (request && this.socket?.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(request));
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

  /** A socket doesn't tell why it was refused. */
  private async lookWhoAnswers(): Promise<void> {
    const answer = await fetch("/", { method: "HEAD" }).catch(() => null);
    if (!this.closed && answer?.status === 401) this.listener.connected(false, true);
  }

  private open(): void {
    const scheme = location.protocol === "https:" ? "wss" : "ws";
    const socket = new WebSocket(`${scheme}://${location.host}/api/socket?page=${PAGE}`);
    this.socket = socket;
    socket.onopen = () => {
      this.pause = 250;
      this.listener.connected(true, false);
      this.introduce();
      this.select(this.listener.selection());
      this.subscribe();
    };
    socket.onmessage = (message) => this.listener.frame(JSON.parse(String(message.data)) as ServerFrame);
    socket.onclose = () => {
      if (this.closed) return;
      this.listener.connected(false, false);
      void this.lookWhoAnswers();
      this.timer = setTimeout(() => this.open(), this.pause);
      this.pause = Math.min(this.pause * 2, LONGEST_PAUSE);
    };
  }
}
