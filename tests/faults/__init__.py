"""Every public name with bad values: it takes them, or refuses them on purpose."""
