"""An external component behind the port `Component`: values in, a ROS call, values out."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from grip_bt.catalog.component_file import ComponentFile
from grip_bt.errors import BadReplyError
from grip_bt.operation import Operation

from .client import ServiceClient
from .convert import from_message, to_message
from .fields import ConversionError, field_types


class RosComponent:
    """A service that keeps the component contract; implements `grip_bt.ports.Component`.

    Args:
        file: what the component is.
        client: the client of its service.
    """

    def __init__(self, file: ComponentFile, client: ServiceClient):
        self.file, self._client = file, client
        self._meaning = list(file.meanings().items())

    def call(self, request: Mapping[str, Any]) -> Operation[Mapping[str, Any]]:
        """Send the request's fields; the result holds the response's fields as the declared values.

        The `outcome` in the result is an integer within the declared ones. A field that can't be converted is left out
        when the outcome means failure, since such an answer often holds nothing of use.

        Ends with ServerLostError, ServerTimeOutError or BadReplyError; with ConversionError when the request is wrong.
        """
        try:
            message = to_message(request, self._client.type.Request)
        except ConversionError as error:
            return Operation.failed(error.below(f"component {self.file.name}: request"))
        return self._client.call(message).then(self._unpack)

    def _unpack(self, response: Any) -> Operation[Mapping[str, Any]]:
        number = getattr(response, "outcome", None)
        if not isinstance(number, int):
            raise BadReplyError(f"component {self.file.name}: the response has no integer field 'outcome'")
        if not 0 <= number < len(self._meaning):
            names = ", ".join(f"{i} {name}" for i, (name, _) in enumerate(self._meaning))
            raise BadReplyError(
                f"component {self.file.name}: outcome {number} isn't one of the declared ones ({names})", outcome=number
            )
        _, meaning = self._meaning[number]
        result: dict[str, Any] = {"outcome": number}
        for field in field_types(type(response)):
            if field == "outcome":
                continue
            try:
                result[field] = from_message(getattr(response, field), self.file.port_type(field, "Any"))
            except ConversionError as error:
                if meaning == "success":
                    reason = f"component {self.file.name}: {error.below(f'response.{field}')}"
                    raise BadReplyError(reason, field=field) from None
        return Operation.finished(result)
