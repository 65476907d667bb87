// SPDX-License-Identifier: Apache-2.0
// Search in pages that are opened as files: there browsers start no worker, so its script runs in a hidden frame.
// The name has to hold "iframe-worker" (mkdocs.yml): else the offline plugin takes one from the network.
if (location.protocol === "file:") {
  window.Worker = class extends EventTarget {
    constructor(url) {
      super();
      const frame = document.createElement("iframe");
      frame.hidden = true;
      document.body.append(frame);
      const inside = frame.contentWindow;
      this.inside = inside;
      inside.postMessage = (data) => this.dispatchEvent(new MessageEvent("message", { data }));
      inside.importScripts = (...urls) => urls.reduce((before, next) => before.then(() => load(inside, next)), Promise.resolve());
      this.ready = load(inside, url);
    }
    set onmessage(handler) {
      this.addEventListener("message", handler);
    }
    postMessage(data) {
      this.ready.then(() => {
        const { inside } = this;
        inside.dispatchEvent(new inside.MessageEvent("message", { data }));
      });
    }
  };

  function load(inside, url) {
    return new Promise((done, failed) => {
      const script = inside.document.createElement("script");
      script.src = url;
      script.onload = done;
      script.onerror = failed;
      inside.document.body.append(script);
    });
  }
}
