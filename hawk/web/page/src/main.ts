export * from "./parts/shared.ts";
import { browserTimers, openBrowserSocket, socketUrl } from "./link/socket.ts";
import { Voice } from "./link/voice.ts";
import { followWindow, Route, windowAddress } from "./route/route.ts";
import { Operator } from "./state/operator.ts";
import { PageLanguage } from "./state/page-language.ts";
import { App, type Person } from "./ui/app.ts";
import { isUnseen } from "./ui/picture-window.ts";
import { say } from "./words/say.ts";

/** How often the page looks at the time while nothing arrives: values must turn old within a second. */
const TICK_MS = 400;

const voice = new Voice(window, () => operator.preferences.sound);
for (const gesture of ["pointerdown", "keydown"]) document.addEventListener(gesture, () => voice.allow(), { once: true });

const operator: Operator = new Operator({
  commandUrl: socketUrl("ws", document.baseURI),
  open: openBrowserSocket,
  timers: browserTimers,
  wallClock: () => Date.now(),
  storage: localStorage,
  say: (text) => voice.say(text),
  session: sessionStorage,
  logIn,
  checkLogin: () => void checkLogin(),
  logOut: () => void logOut(),
});

const language = new PageLanguage({
  languages: () => navigator.languages,
  read: readMessages,
  changed: (name) => {
    document.documentElement.lang = name;
    operator.drawAgain();
  },
});
const followLanguage = (): void => void language.follow(operator.preferences.language);
operator.addEventListener("change", followLanguage);
window.addEventListener("languagechange", followLanguage);
followLanguage();

async function readMessages(file: string): Promise<string> {
  const answer = await fetch(new URL(file, document.baseURI));
  if (!answer.ok) throw new Error(`${answer.status} ${answer.statusText}`);
  return await answer.text();
}

function logIn(): void {
  location.replace(new URL("login", document.baseURI));
}

async function checkLogin(): Promise<void> {
  const status = await fetch("api/session", { cache: "no-store" }).then((answer) => answer.status, () => 0);
  if (status === 401) logIn();
}

async function logOut(): Promise<void> {
  const left = await fetch("logout", { method: "POST" }).then((answer) => answer.ok || answer.status === 401, () => false);
  if (left) logIn();
  else operator.toasts.show({ level: "error", text: say("log-out-unanswered") });
}

const route = new Route(windowAddress());
followWindow(route);

/** The operator's presence ends with the page: while the motors are on the browser asks before it goes. */
window.addEventListener("beforeunload", (event) => {
  if (operator.isFlyingIt) event.preventDefault();
});

const apps = [...document.querySelectorAll("hawk-app")].filter((app) => app instanceof App);
if (apps.some((app) => app.isForSome) && location.hash === "") route.settle({ view: "lots" });
for (const app of apps) Object.assign(app, { model: operator, route });

if (apps.some((app) => app.isForSome)) {
  void showPerson();
  document.addEventListener("visibilitychange", () => void showPerson());
} else live();

/** Whose lots are shown; the login page where the login has ended. */
async function showPerson(): Promise<void> {
  const answer = await fetch("api/session", { cache: "no-store" }).catch(() => null);
  if (answer?.status === 401) logIn();
  if (!answer?.ok) return;
  const person = (await answer.json()) as Person;
  for (const app of apps) app.person = person;
}

/** The drone is heard, and hears from this page. */
function live(): void {
  operator.connect();
  const life = new Worker(new URL("life-worker.js", document.baseURI));
  const showLife = (): void => operator.signOfLife(isUnseen());
  life.onmessage = showLife;
  document.addEventListener("visibilitychange", showLife);
  setInterval(() => {
    const silent = operator.view().silence;
    if (!document.hidden && (silent === null || silent > TICK_MS / 1000)) operator.tick();
  }, TICK_MS);
}
