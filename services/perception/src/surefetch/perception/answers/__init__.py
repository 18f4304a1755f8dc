"""The four questions, answered without weights from pixels and fitted solids."""
