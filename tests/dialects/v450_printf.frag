#version 450
#extension GL_EXT_debug_printf : enable
#define NOTE "say \"so\"\n"
layout (location = 0) out vec4 c; // not a "string \ here"
void main()
{
    debugPrintfEXT(NOTE);
    debugPrintfEXT("a \\ b \x41 \? %d", 1);
    c = vec4(1.0);
}
