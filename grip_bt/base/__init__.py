"""What travels between the rooms.

`errors` and `failures`, `values` and their bytes (`value_codec`), `operation`, `ports` (every Protocol between rooms),
`issue`, `yaml/` (files with the place of everything), `expression` and `evaluation`, `types`, `message_store`.
"""
