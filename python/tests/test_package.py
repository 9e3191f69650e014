"""The package itself: documentation, types, one tree of errors."""

import dataclasses
import doctest
import importlib.resources
import inspect

import pytest
import twinhub

PUBLIC = [name for name in twinhub.__all__ if not name.startswith("__")]


def test_all_names_everything_public():
    visible = {
        name
        for name, value in vars(twinhub).items()
        if not name.startswith("_") and not inspect.ismodule(value)
    }
    assert visible == set(PUBLIC)


@pytest.mark.parametrize("name", PUBLIC)
def test_every_public_name_is_documented(name):
    thing = getattr(twinhub, name)
    assert thing.__doc__ and not thing.__doc__.startswith(f"{name}(")
    if inspect.isfunction(thing):
        assert "Returns\n" in thing.__doc__
        for argument in inspect.signature(thing).parameters:
            assert f"    {argument} : " in thing.__doc__, argument
    if dataclasses.is_dataclass(thing):
        for field in dataclasses.fields(thing):
            assert field.name in thing.__doc__, field.name
    if inspect.isclass(thing):
        for member, value in vars(thing).items():
            if not member.startswith("_") and (inspect.isfunction(value) or isinstance(value, property)):
                assert value.__doc__, member


def test_every_attribute_of_a_ride_is_documented(ride_and_file):
    ride, _ = ride_and_file
    text = f"{twinhub.Log.__doc__}{twinhub.Ride.__doc__}"
    for attribute in vars(ride):
        if not attribute.startswith("_"):
            assert f"{attribute} : " in text, attribute


@pytest.mark.parametrize("module", ["_batch", "_bicycle", "_controller", "_linear", "_log", "_map", "_messages", "_modes", "_ride"])
def test_examples_in_the_documentation_hold(module):
    result = doctest.testmod(importlib.import_module(f"twinhub.{module}"))
    assert result.failed == 0


def test_examples_are_there():
    finder = doctest.DocTestFinder()
    for function in (twinhub.modes, twinhub.parameters, twinhub.ride):
        assert any(test.examples for test in finder.find(function)), function.__name__


def test_errors_are_one_tree():
    for name in PUBLIC:
        thing = getattr(twinhub, name)
        if inspect.isclass(thing) and issubclass(thing, BaseException):
            assert issubclass(thing, twinhub.TwinhubError), name
    assert issubclass(twinhub.InputError, ValueError)
    assert str(twinhub.UnknownNameError("no 'x'")) == "no 'x'"


def test_types_are_shipped():
    files = {file.name for file in importlib.resources.files(twinhub).iterdir()}
    assert {"py.typed", "_twinhub.pyi", "_twinhub.abi3.so"} <= files
