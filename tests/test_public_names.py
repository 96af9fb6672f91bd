import importlib
import pkgutil

import pytest

import circumspect


@pytest.mark.parametrize("name", circumspect.__all__)
def test_every_public_name_resolves_and_is_documented(name):
    value = getattr(circumspect, name)
    assert value.__doc__
    assert name in dir(circumspect)


def test_all_of_every_package_resolves():
    for module in pkgutil.walk_packages(circumspect.__path__, "circumspect."):
        if module.name.endswith("__main__"):
            continue
        imported = importlib.import_module(module.name)
        for name in getattr(imported, "__all__", ()):
            assert getattr(imported, name) is not None


def test_unknown_names_are_attribute_errors():
    with pytest.raises(AttributeError, match="colour"):
        circumspect.colour  # noqa: B018
