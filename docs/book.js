// Tables and blocks that are wider than the page scroll; the keyboard reaches them too.
for (const wide of document.querySelectorAll(".table-wrapper, pre > code")) {
    wide.tabIndex = 0;
}
