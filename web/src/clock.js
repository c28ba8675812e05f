// The time shown: one value that the animation, the slider and every chart follow.

export class Clock {
  constructor(duration) {
    this.duration = duration;
    this.time = 0;
    this.speed = 1;
    this.loop = false;
    this.playing = false;
    this.listeners = [];
    this.last = 0;
  }

  listen(listener) {
    this.listeners.push(listener);
    listener(this);
  }

  set(time) {
    this.time = Math.min(Math.max(time, 0), this.duration);
    this.tell();
  }

  toggle() {
    this.playing = !this.playing;
    if (this.playing) {
      if (this.time >= this.duration) this.time = 0;
      this.last = performance.now();
      requestAnimationFrame((now) => this.tick(now));
    }
    this.tell();
  }

  tick(now) {
    if (!this.playing) return;
    let time = this.time + this.speed * Math.max(now - this.last, 0) / 1000;
    this.last = now;
    if (time >= this.duration) {
      this.playing = this.loop;
      time = this.loop ? 0 : this.duration;
    }
    this.set(time);
    if (this.playing) requestAnimationFrame((next) => this.tick(next));
  }

  tell() {
    for (const listener of this.listeners) listener(this);
  }
}
