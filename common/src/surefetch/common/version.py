"""The one version that all distributions carry and `surefetch --version` prints."""

from importlib.metadata import version

VERSION = version("surefetch-common")
