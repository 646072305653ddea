using System;
using System.Collections.Generic;

namespace FaceBaker
{
    /// <summary>Controls by group and by what somebody types, for panels of sliders.</summary>
    public static class ControlSearch
    {
        /// <summary>The controls whose name, group, ARKit or FACS name contains the text, in any case ("": all), by group:
        /// groups and controls in the order of the face.</summary>
        public static List<KeyValuePair<string, List<Control>>> ByGroup(IReadOnlyList<Control> controls, string text)
        {
            var groups = new List<KeyValuePair<string, List<Control>>>();
            var places = new Dictionary<string, int>();
            foreach (Control control in controls)
            {
                if (!Has(control.Name, text) && !Has(control.Group, text) && !Has(control.ArKit, text) &&
                    !Has(control.Facs, text))
                    continue;
                int place;
                if (!places.TryGetValue(control.Group, out place))
                {
                    place = groups.Count;
                    places.Add(control.Group, place);
                    groups.Add(new KeyValuePair<string, List<Control>>(control.Group, new List<Control>()));
                }
                groups[place].Value.Add(control);
            }
            return groups;
        }

        private static bool Has(string where, string text)
        {
            return where.IndexOf(text, StringComparison.OrdinalIgnoreCase) >= 0;
        }
    }
}
