import { language } from "../words/say.ts";

/** What is needed of a browser to be heard; each may be absent. */
export interface Speaker {
  speechSynthesis?: Pick<SpeechSynthesis, "speak" | "cancel">;
  SpeechSynthesisUtterance?: new (text: string) => SpeechSynthesisUtterance;
  AudioContext?: new () => AudioContext;
}

/** Hertz and seconds of the tone before the words. */
const TONE_HZ = 880;
const TONE_S = 0.25;
const LOUDNESS = 0.2;

/** Speaks what the eye may miss. Browsers allow sound after a gesture only; without it, and without a voice, it is silent. */
export class Voice {
  private readonly speaker: Speaker;
  private readonly wanted: () => boolean;
  private context: AudioContext | null = null;
  private allowed = false;

  constructor(speaker: Speaker, wanted: () => boolean) {
    this.speaker = speaker;
    this.wanted = wanted;
  }

  /** To be called in a gesture: from now on it may be heard. */
  allow(): void {
    if (this.allowed) return;
    this.allowed = true;
    quietly(() => {
      if (this.speaker.AudioContext) this.context = new this.speaker.AudioContext();
    });
  }

  say(text: string): void {
    if (!this.allowed || !this.wanted()) return;
    quietly(() => this.beep());
    quietly(() => this.speak(text));
  }

  private beep(): void {
    const context = this.context;
    if (!context) return;
    if (context.state === "suspended") void context.resume().catch(() => undefined);
    const tone = context.createOscillator();
    const loudness = context.createGain();
    loudness.gain.value = LOUDNESS;
    tone.frequency.value = TONE_HZ;
    tone.connect(loudness).connect(context.destination);
    tone.start();
    tone.stop(context.currentTime + TONE_S);
  }

  private speak(text: string): void {
    const { speechSynthesis: speech, SpeechSynthesisUtterance: Utterance } = this.speaker;
    if (!speech || !Utterance) return;
    const words = new Utterance(text);
    words.lang = language();
    speech.cancel();
    speech.speak(words);
  }
}

/** A browser that cannot be heard is no error. */
function quietly(run: () => void): void {
  try {
    run();
  } catch (error) {
    console.warn("sound", error);
  }
}
