// Sphinx's weights, but for pages: somebody who searches for words of the program wants their remedy first.
const FIRST = { troubleshooting: 20, settings: 5, CHANGELOG: -10 };
var Scorer = {
  score: ([page, , , , score]) => score + (FIRST[page] ?? (/^(decisions|results)\//.test(page) ? -5 : 0)),
  objNameMatch: 11,
  objPartialMatch: 6,
  objPrio: { 0: 15, 1: 5, 2: -5 },
  objPrioDefault: 0,
  title: 15,
  partialTitle: 7,
  term: 5,
  partialTerm: 2,
};
