"use strict";
// What scrolls sideways can be reached by keyboard, too.
addEventListener("load", () => {
  for (const each of document.querySelectorAll(".md-typeset__scrollwrap, pre, pre > code, .highlight-ipynb")) {
    if (each.scrollWidth > each.clientWidth) each.tabIndex = 0;
  }
});
