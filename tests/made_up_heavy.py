"""A command whose module needs a package that nobody has."""

import importlib

driver = importlib.import_module("a_drivers_package")
