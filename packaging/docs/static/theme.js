// Before anything is drawn: the theme that was chosen last.
document.body.dataset.theme = localStorage.getItem("theme") || "auto";
