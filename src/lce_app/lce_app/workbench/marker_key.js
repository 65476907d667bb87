// SPDX-License-Identifier: Apache-2.0
// The key M, outside of a field, puts the cursor into the field of the marker at once: what is typed next is its text.
export default {
  template: "<span hidden></span>",
  mounted() {
    this.onKey = (event) => {
      if (event.key.toLowerCase() !== "m" || event.ctrlKey || event.altKey || event.metaKey || event.repeat) return;
      if (["INPUT", "TEXTAREA", "SELECT"].includes(document.activeElement?.tagName)) return;
      const field = document.querySelector(".marker-text input");
      if (!field) return;
      event.preventDefault();
      field.focus();
      this.$emit("pressed");
    };
    document.addEventListener("keydown", this.onKey);
  },
  unmounted() {
    document.removeEventListener("keydown", this.onKey);
  },
};
