"""What travels between the rooms.

`errors` and `failures` (what a task expects), `values` (frozen, read-only arrays; units and frames stated),
`operation` (a request under way), `ports` (every Protocol between rooms), `issue` (what is wrong, and where), `yaml/`
(files with the place of everything), `expression` and `evaluation`, `types` (of ports and variables),
`message_store`, `files`.
"""
