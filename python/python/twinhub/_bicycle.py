"""Bicycles and their parameters."""

from . import _twinhub
from ._arguments import Assignments, NameOrPath, assignments
from ._things import Bicycle, of


def bicycles() -> list[str]:
    """Names of the built-in parameter sets.

    Returns
    -------
    list of str
        Publication names, as `parameters` and `modes` take them.

    Examples
    --------
    >>> import twinhub
    >>> "meijaard2007_benchmark" in twinhub.bicycles()
    True
    """
    return _twinhub.bicycles()


def parameters(bicycle: NameOrPath | Bicycle, set: Assignments | None = None) -> dict[str, float]:
    """Parameters of the benchmark (Whipple-Carvallo) bicycle.

    Parameters
    ----------
    bicycle : str or os.PathLike
        A built-in name (see `bicycles`), a bicycle ``.toml``, a ``*Benchmark.txt`` of the
        BicycleParameters project, or ``BICYCLE+RIDER``.
    set : mapping or list of str, optional
        Values to change, by symbol: ``{"c": 0.05}`` or ``["c=0.05"]``.

    Returns
    -------
    dict of str to float
        SI value by symbol of Meijaard et al. (2007), table 1, in the order of that table; units
        from `parameter_units`. The rear body ``B`` has the rider on it.

    Raises
    ------
    InputError
        If there is no such bicycle or symbol, or a value lies outside what is possible.

    Examples
    --------
    >>> import twinhub
    >>> twinhub.parameters("meijaard2007_benchmark")["w"]
    1.02
    """
    name, changes = of("bicycle", bicycle)
    return _twinhub.parameters(name, [*changes, *assignments(set)])


def parameter_units() -> dict[str, str]:
    """Units of the parameters.

    Returns
    -------
    dict of str to str
        Unit by symbol, for instance ``"kg m^2"`` for ``"IBxx"``.
    """
    return _twinhub.parameter_units()
