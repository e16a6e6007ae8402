"""What the tests of all commands share."""

import pytest

from frictionlab.cli.command import main


@pytest.fixture
def refused(capsys):
    """Run a command that must end with code 2 and one line, with nothing done; returns the line."""

    def refused(command, *options):
        with pytest.raises(SystemExit) as ended:
            main([command, *options])
        assert ended.value.code == 2
        out, err = capsys.readouterr()
        assert out == ""
        assert err.startswith(f"frictionlab {command}: error: ")
        assert err.count("\n") == 1
        return err.replace("\\", "/")

    return refused
