"""Strings that more than one area uses."""

ZH = {
    "Cancel": "取消",
    "Cancelling": "正在取消",
}
