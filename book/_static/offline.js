// A page that lies in a file may not read other files: no excerpts in search results.
if (location.protocol === "file:") { DOCUMENTATION_OPTIONS.SHOW_SEARCH_SUMMARY = false; }
