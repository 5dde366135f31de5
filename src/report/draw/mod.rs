//! Draw: a page becomes files. Nothing here measures.
