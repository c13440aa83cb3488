//! Parts of the shapes of a family: masks over the vertices of its template, and pairs of them.
