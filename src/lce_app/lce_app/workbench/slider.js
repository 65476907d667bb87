// SPDX-License-Identifier: Apache-2.0
// A native range input: unlike Quasar's slider, what has the focus is what has the name.
export default {
  template: '<input type="range" min="0" :max="steps" :value="at" @input="move" />',
  props: { began: Number, steps: Number },
  data() { return { at: this.began }; },
  methods: {
    move(event) {
      this.at = Number(event.target.value);
      this.$emit("move", this.at);
    },
    back() { this.at = this.began; },
  },
};
