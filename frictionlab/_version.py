"""The version, in the one place that the build, the citation test and saved runs read."""

__version__ = "0.1.0"
