// A page that is a file may not read other files, which lines of text beside what was found would need.
if (location.protocol === "file:") DOCUMENTATION_OPTIONS.SHOW_SEARCH_SUMMARY = false;
