"""What goes over the wire between server and page: pydantic models, from which the page's types are generated."""
